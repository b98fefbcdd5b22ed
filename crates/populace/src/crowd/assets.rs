//! Views of the characters and clips of a crowd.

use std::sync::Arc;

use populace_character::Character;
use populace_clip::{Clip, LiveSettings};
use populace_model::{Mask, RoleMap, Trs};
use populace_retarget::BindingReport;
use populace_settings::parts::Parts;

use super::member::MemberRef;
use super::state::State;
use super::{BlendSpaceId, CharacterId, ClipId, Crowd, MachineId, MaskId, ParameterId};
use crate::{BlendSpace, Contact, Error, StateMachine};

/// A view that reads a character; see [`Crowd::character`].
#[derive(Clone, Copy)]
pub struct CharacterRef<'a> {
    state: &'a State,
    id: CharacterId,
}

/// A view by which a character can be changed; see [`Crowd::character_mut`].
pub struct CharacterMut<'a> {
    crowd: &'a mut Crowd,
    id: CharacterId,
}

/// A borrowed view of a clip; see [`Crowd::clip_mut`].
pub struct ClipMut<'a> {
    crowd: &'a mut Crowd,
    id: ClipId,
}

impl Crowd {
    /// Adds a character with its clips.
    ///
    /// # Errors
    ///
    /// More data than devices can address. Nothing is added then.
    pub fn add_character(
        &mut self,
        character: impl Into<Arc<Character>>,
    ) -> Result<CharacterId, Error> {
        self.state.add_character(character.into())
    }

    /// Returns a view of a character.
    ///
    /// # Errors
    ///
    /// [`Error::UnknownId`] for a character of another crowd.
    pub fn character(&self, id: CharacterId) -> Result<CharacterRef<'_>, Error> {
        self.state.base.character_state(id)?;
        Ok(CharacterRef { state: &self.state, id })
    }

    /// Returns a view of a character by which it can be changed.
    ///
    /// # Errors
    ///
    /// [`Error::UnknownId`] for a character of another crowd.
    pub fn character_mut(&mut self, id: CharacterId) -> Result<CharacterMut<'_>, Error> {
        self.state.base.character_state(id)?;
        Ok(CharacterMut { crowd: self, id })
    }

    /// Returns the clip of a character by name.
    ///
    /// # Errors
    ///
    /// [`Error::UnknownClip`] with similar names.
    pub fn clip(&self, character: CharacterId, name: &str) -> Result<ClipId, Error> {
        self.state.base.clip(character, name)
    }

    /// Returns a view of a clip by which it can be changed.
    ///
    /// # Errors
    ///
    /// [`Error::UnknownId`] for a clip of another crowd.
    pub fn clip_mut(&mut self, id: ClipId) -> Result<ClipMut<'_>, Error> {
        self.state.base.known_clip(id)?;
        Ok(ClipMut { crowd: self, id })
    }

    /// Adds a blend space. Members of any character can play it.
    ///
    /// # Errors
    ///
    /// A clip of another crowd, or [`Error::BadBlendSpace`] for a live clip, which has no cycle.
    pub fn add_blend_space(&mut self, space: BlendSpace) -> Result<BlendSpaceId, Error> {
        let (player, base) = self.state.player();
        player.add_blend_space(base, space)
    }

    /// Adds a state machine. Members of any character can run it.
    ///
    /// # Errors
    ///
    /// [`Error::BadStateMachine`] for a machine without states, with more than 8 parameters, with a
    /// duplicate or unknown name, or with a condition on the end of a clip that has none; a clip of
    /// another crowd; a number that is not finite; a live clip that is not played as one.
    pub fn add_machine(&mut self, machine: &StateMachine) -> Result<MachineId, Error> {
        let (player, base) = self.state.player();
        player.add_machine(base, machine)
    }

    /// Returns the id of a machine's parameter, which is faster to set by than its name.
    ///
    /// # Errors
    ///
    /// [`Error::BadStateMachine`] with similar names, or a machine of another crowd.
    pub fn parameter(&self, machine: MachineId, name: &str) -> Result<ParameterId, Error> {
        self.state.player.parameter(&self.state.base, machine, name)
    }
}

impl<'a> CharacterRef<'a> {
    /// The character's handle.
    #[must_use]
    pub const fn id(&self) -> CharacterId {
        self.id
    }

    /// Returns the character as it was added.
    #[must_use]
    pub fn asset(&self) -> &'a Arc<Character> {
        &self.state.base.assets.characters[self.id.parts().index].character
    }

    /// Returns the clips of the character, in the order in which they were added.
    #[must_use]
    pub fn clips(&self) -> Vec<(ClipId, Arc<Clip>)> {
        self.state.base.clips(self.id).map(|(id, clip)| (id, Arc::clone(clip))).collect()
    }

    /// Iterates over the members of the character, in order of their indices.
    pub fn members(&self) -> impl Iterator<Item = MemberRef<'a>> + use<'a> {
        let id = self.id;
        self.state.members().filter(move |member| member.character() == id)
    }

    /// Returns the humanoid roles of the character's joints, detected from their names or set;
    /// `None` if neither.
    #[must_use]
    pub fn roles(&self) -> Option<&'a RoleMap> {
        self.state.base.assets.characters[self.id.parts().index].roles.as_ref()
    }

    /// Reports how well a clip fits the character: how its joints are found, the share of its
    /// joints that are bound, and the difference of the rest poses.
    ///
    /// A clip bound by names alone is refused below [`BindingReport::LEAST_SHARE`], unless played
    /// by [`ClipPlayback::partial`](crate::ClipPlayback::partial). Between that and 80 % it plays
    /// with a part of its motion missing.
    ///
    /// # Errors
    ///
    /// A clip of another crowd, or one that drives no joint of the character. A clip that drives
    /// some of them, but moves others only, has a report with no bound joints, and cannot be
    /// played.
    pub fn binding(&self, clip: ClipId) -> Result<BindingReport, Error> {
        self.state.base.binding(self.id, clip)
    }
}

impl State {
    /// Adds a character with its clips. Takes it out again if they do not all fit.
    fn add_character(&mut self, character: Arc<Character>) -> Result<CharacterId, Error> {
        let clips = character.clips.clone();
        let id = self.base.add_body(character)?;
        let added = clips.iter().try_for_each(|clip| self.base.add_clip(id, clip).map(drop));
        if let Err(error) = added {
            self.remove_character(id)?;
            return Err(error);
        }
        Ok(id)
    }
}

impl CharacterMut<'_> {
    /// Adds a clip under its name, at any time. Other characters can play it too.
    ///
    /// # Errors
    ///
    /// More data than devices can address.
    pub fn add_clip(&mut self, clip: &Arc<Clip>) -> Result<ClipId, Error> {
        self.crowd.state.base.add_clip(self.id, clip)
    }

    /// Sets when feet stand while the character plays a clip, in place of what was set before.
    /// Planted feet then lock from contact to lift-off; without contacts they lock while the ankle
    /// is near its height at rest. Members that play the clip already follow from the next update
    /// on. `populace-locomotion` measures contacts.
    ///
    /// # Errors
    ///
    /// A clip of another crowd or one that does not fit the character, a contact outside of the
    /// clip, an ankle that does not exist, or more data than devices can address.
    pub fn set_contacts(&mut self, clip: ClipId, contacts: &[Contact]) -> Result<(), Error> {
        self.crowd.state.base.set_contacts(self.id, clip, contacts)
    }

    /// Adds a live clip: [`ClipMut::append`] adds poses of the character's skeleton while members
    /// play it with [`ClipPlayback::live`](crate::ClipPlayback::live). Other characters can play it
    /// like any clip. [`Clip::live`] makes a live clip for any skeleton,
    /// [`add_clip`](Self::add_clip) adds it.
    ///
    /// ```
    /// # use populace::{Crowd, Device, LiveSettings, Placement, ClipPlayback, Trs};
    /// # let mut crowd = Crowd::builder().device(Device::native()).build()?;
    /// # let knight = populace::doc_fixture::knight(&mut crowd)?;
    /// # let member = crowd.spawn(knight, Placement::at([0.0; 3]))?;
    /// let settings = LiveSettings::default();
    /// let actor = crowd.character_mut(knight)?.add_live_clip("Actor", &settings)?;
    /// crowd.member_mut(member)?.play(actor, ClipPlayback::live(0.1))?;
    /// for frame in 0..60 {
    ///     let pose = Trs { translation: [0.0, frame as f32 / 60.0, 0.0], ..Trs::IDENTITY };
    ///     crowd.clip_mut(actor)?.append(f64::from(frame) / 60.0, &[pose])?;
    ///     crowd.update(1.0 / 60.0)?;
    /// }
    /// let hips = crowd.member_mut(member)?.model_from_joints()?[0];
    /// assert!((hips.rows[1][3] - 0.9).abs() < 1e-3, "the hips 0.1 seconds ago");
    /// # Ok::<(), populace::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Settings out of their range, names of joints that do not exist, or more data than devices
    /// can address.
    pub fn add_live_clip(&mut self, name: &str, settings: &LiveSettings) -> Result<ClipId, Error> {
        let skeleton = &self.crowd.state.base.character_state(self.id)?.character.skeleton;
        let clip = Clip::live(name, skeleton, settings)?;
        self.add_clip(&Arc::new(clip))
    }

    /// Adds a mask.
    ///
    /// # Errors
    ///
    /// A mask of another skeleton, or more data than devices can address.
    pub fn add_mask(&mut self, mask: &Mask) -> Result<MaskId, Error> {
        self.crowd.state.base.add_mask(self.id, mask)
    }

    /// Sets the humanoid roles of the character's joints, in place of those detected from names.
    /// Retargeting from and to the character uses them from now on. Clips that already play keep
    /// their binding.
    ///
    /// # Errors
    ///
    /// A map of another skeleton.
    pub fn set_roles(&mut self, roles: RoleMap) -> Result<(), Error> {
        let (player, base) = self.crowd.state.player();
        base.set_roles(self.id, roles)?;
        player.machines.unbind();
        Ok(())
    }
}

impl ClipMut<'_> {
    /// Returns the clip as it was added.
    #[must_use]
    pub fn asset(&self) -> &Arc<Clip> {
        &self.crowd.state.base.assets.clips[self.id.parts().index]
    }

    /// Appends a pose to a live clip: local transforms of all joints of the clip's own skeleton, in
    /// level order, in metres. `time_secs` is the time of the pose on the stream's clock, later
    /// than that of the pose before.
    ///
    /// The first pose is aligned with the present of the crowd, the last update. From then on a
    /// second of the stream is a second of the crowd; [`resync`](Self::resync) aligns them again.
    /// Poses may arrive unevenly, several or none between two updates: rows are interpolated
    /// linearly between them, rotations on the shorter way. The call does not wait for a device.
    ///
    /// # Errors
    ///
    /// [`populace_clip::Error::BadLive`] for a clip that is not live, a time that is not after the
    /// last, a wrong number of joints, numbers that are not finite, or a rotation of no length.
    pub fn append(&mut self, time_secs: f64, pose: &[Trs]) -> Result<(), Error> {
        let State { base, live, .. } = &mut self.crowd.state;
        live.append(base, self.id, time_secs, pose)
    }

    /// Appends a pose of the named joints. The others keep their last transforms, at first the rest
    /// pose. Otherwise as [`append`](Self::append).
    ///
    /// # Errors
    ///
    /// As for [`append`](Self::append), and [`populace_model::Error::UnknownJoints`] with similar
    /// names.
    pub fn append_joints(&mut self, time_secs: f64, joints: &[(&str, Trs)]) -> Result<(), Error> {
        let State { base, live, .. } = &mut self.crowd.state;
        live.append_joints(base, self.id, time_secs, joints)
    }

    /// Aligns `time_secs` of a live clip's stream with the present of the crowd, such as after the
    /// crowd was paused while poses arrived, or when the clocks have drifted apart. Members that
    /// play the clip jump to the new time.
    ///
    /// # Errors
    ///
    /// [`populace_clip::Error::BadLive`] for a clip that is not live or has no pose yet, or a time
    /// that is not finite or far from the stream's.
    pub fn resync(&mut self, time_secs: f64) -> Result<(), Error> {
        let State { base, live, .. } = &mut self.crowd.state;
        live.resync(base, self.id, time_secs)
    }

    /// Adds an event marker at `secs` on the clip's own time axis. Members with
    /// [subscribed events](crate::MemberMut::subscribe_events) report it.
    ///
    /// # Errors
    ///
    /// A time outside of the clip.
    pub fn add_event_marker(&mut self, name: &str, secs: f32) -> Result<(), Error> {
        let State { base, events, .. } = &mut self.crowd.state;
        events.add_marker(base, self.id, name, secs)
    }

    /// Sets the humanoid roles of the skeleton that the clip was made for, which need not be the
    /// skeleton of a character.
    ///
    /// # Errors
    ///
    /// A map of another skeleton.
    pub fn set_roles(&mut self, roles: RoleMap) -> Result<(), Error> {
        let (player, base) = self.crowd.state.player();
        base.set_clip_roles(self.id, roles)?;
        player.machines.unbind();
        Ok(())
    }
}
