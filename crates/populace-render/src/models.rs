//! The characters that have been uploaded, found by their address.

use std::collections::HashMap;
use std::rc::Rc;
use std::sync::{Arc, Weak};

use populace_character::{Character, Part};

use crate::Error;
use crate::gl::Gl;
use crate::model::{Model, Shared};

/// Uploaded characters. A character's address is not used again while its [`Weak`] is held.
pub(crate) struct Models {
    shared: Shared,
    models: Vec<Model>,
    owners: Vec<Weak<Character>>,
    indices: Known,
}

/// The index of each model by the address of its character, as a number, so that threads can share
/// them.
#[derive(Default)]
pub(crate) struct Known(HashMap<usize, usize>);

impl Known {
    pub(crate) fn find(&self, character: &Arc<Character>) -> Option<usize> {
        self.0.get(&Arc::as_ptr(character).addr()).copied()
    }
}

impl Models {
    pub(crate) fn new(gl: &Rc<Gl>) -> Result<Self, Error> {
        let (models, owners, indices) = (Vec::new(), Vec::new(), Known::default());
        Ok(Self { shared: Shared::new(gl)?, models, owners, indices })
    }

    /// Returns the meshes of all models.
    pub(crate) fn shared(&self) -> &Shared {
        &self.shared
    }

    /// Returns the index of each model by its character.
    pub(crate) fn known(&self) -> &Known {
        &self.indices
    }

    /// Returns all models. Their order changes when some are released.
    pub(crate) fn as_slice(&self) -> &[Model] {
        &self.models
    }

    /// Uploads a character without the parts for which `hide` returns true. It replaces an earlier
    /// upload. Returns the index of the model.
    pub(crate) fn upload(
        &mut self,
        gl: &Rc<Gl>,
        character: &Arc<Character>,
        hide: &dyn Fn(&Part) -> bool,
    ) -> Result<usize, Error> {
        let model = Model::new(gl, &mut self.shared, character, hide)?;
        if let Some(index) = self.indices.find(character) {
            self.models[index] = model;
            return Ok(index);
        }
        let index = self.models.len();
        self.models.push(model);
        self.owners.push(Arc::downgrade(character));
        self.indices.0.insert(Arc::as_ptr(character).addr(), index);
        Ok(index)
    }

    /// Returns the index of a character's model. A character that is not known is uploaded whole.
    pub(crate) fn index_of(
        &mut self,
        gl: &Rc<Gl>,
        character: &Arc<Character>,
    ) -> Result<usize, Error> {
        match self.indices.find(character) {
            Some(index) => Ok(index),
            None => self.upload(gl, character, &|_| false),
        }
    }

    /// Releases the models of characters that nothing holds any more.
    pub(crate) fn release_unused(&mut self) {
        for index in (0..self.owners.len()).rev() {
            if self.owners[index].strong_count() == 0 {
                self.models.swap_remove(index);
                let owner = self.owners.swap_remove(index);
                self.indices.0.remove(&owner.as_ptr().addr());
                if let Some(moved) = self.owners.get(index) {
                    self.indices.0.insert(moved.as_ptr().addr(), index);
                }
            }
        }
    }
}
