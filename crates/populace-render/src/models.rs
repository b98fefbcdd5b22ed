//! The characters that have been uploaded, found by their address.

use std::collections::HashMap;
use std::rc::Rc;
use std::sync::{Arc, Weak};

use populace_character::{Character, Part};

use crate::Error;
use crate::gl::Gl;
use crate::model::Model;

/// Uploaded characters. A character's address is not used again while its [`Weak`] is held.
#[derive(Default)]
pub(crate) struct Models {
    models: Vec<Model>,
    owners: Vec<Weak<Character>>,
    indices: HashMap<*const Character, usize>,
}

impl Models {
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
        let model = Model::new(gl, character, hide)?;
        if let Some(&index) = self.indices.get(&Arc::as_ptr(character)) {
            self.models[index] = model;
            return Ok(index);
        }
        let index = self.models.len();
        self.models.push(model);
        self.owners.push(Arc::downgrade(character));
        self.indices.insert(Arc::as_ptr(character), index);
        Ok(index)
    }

    /// Returns the index of a character's model. A character that is not known is uploaded whole.
    pub(crate) fn index_of(
        &mut self,
        gl: &Rc<Gl>,
        character: &Arc<Character>,
    ) -> Result<usize, Error> {
        match self.indices.get(&Arc::as_ptr(character)) {
            Some(&index) => Ok(index),
            None => self.upload(gl, character, &|_| false),
        }
    }

    /// Releases the models of characters that nothing holds any more.
    pub(crate) fn release_unused(&mut self) {
        for index in (0..self.owners.len()).rev() {
            if self.owners[index].strong_count() == 0 {
                self.models.swap_remove(index);
                let owner = self.owners.swap_remove(index);
                self.indices.remove(&owner.as_ptr());
                if let Some(moved) = self.owners.get(index) {
                    self.indices.insert(moved.as_ptr(), index);
                }
            }
        }
    }
}
