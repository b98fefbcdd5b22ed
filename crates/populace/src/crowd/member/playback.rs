//! Views of a member: playback.

use std::borrow::Borrow;
use std::sync::Arc;

use populace_device::LayerSettings;
use populace_settings::parts::Parts;

use super::super::state::State;
use super::super::{BlendSpaceId, ClipId, MachineId, MaskId, Parameter, PlaybackId};
use super::{MemberMut, MemberView};
use crate::{ActiveClip, BlendSpacePlayback, ClipPlayback, Error, MachinePlayback, SpacePoint};

impl<C: Borrow<State>> MemberView<C> {
    /// Returns the clips that the member plays now, by layer and then by the order in which they
    /// were started. Scheduled clips, clips that have faded out and the clips of state machines
    /// are not among them: only the device knows the state of a machine, and
    /// [`machine_state`](Self::machine_state) asks it.
    #[must_use]
    pub fn active_clips(&self) -> Vec<ActiveClip> {
        let State { base, player, live, .. } = &self.state();
        player.active_clips(base, live, self.id)
    }

    /// Returns the phase that all clips of the member's blend space share now, 0 to 1; `None` if it
    /// plays none.
    #[must_use]
    pub fn blend_space_phase(&self) -> Option<f32> {
        let State { base, player, .. } = &self.state();
        player.space_phase(base, self.id)
    }
}

impl MemberMut<'_> {
    /// Plays a clip on the layer of `playback`, from now on or after its delay. The layer's other
    /// clips fade out as this one fades in, and its queue is cleared.
    ///
    /// If all slots of the member are taken, the weakest fades out first and the clip starts
    /// shortly after, so that the pose never jumps. A clip without a fade takes the weakest slot
    /// at once. A member with one slot cannot fade.
    ///
    /// # Errors
    ///
    /// An id of another crowd, a setting that is out of its range, or a clip that does not fit the
    /// character ([`CharacterRef::binding`](crate::CharacterRef::binding)).
    #[inline]
    pub fn play(&mut self, clip: ClipId, playback: ClipPlayback) -> Result<PlaybackId, Error> {
        let (player, base) = self.crowd.state.player();
        player.play(base, self.id, self.character, clip, playback.parts())
    }

    /// Adds a clip to those that the layer plays. Clips of one layer are mixed by their weights.
    ///
    /// # Errors
    ///
    /// As for [`play`](Self::play).
    pub fn blend(&mut self, clip: ClipId, playback: ClipPlayback) -> Result<PlaybackId, Error> {
        let (player, base) = self.crowd.state.player();
        player.blend(base, self.id, self.character, clip, playback.parts())
    }

    /// Plays a clip when the newest clip of the layer ends: a clip that plays once at its end, a
    /// loop at the end of its cycle. It starts at once if the layer plays nothing, a held clip or
    /// a live clip. Queued clips start one after the other, and a delay counts from the end of the
    /// clip before, which holds its end while the next one fades in.
    ///
    /// ```
    /// # use populace::{Crowd, Device, Placement, ClipPlayback};
    /// # let mut crowd = Crowd::builder().device(Device::native()).build()?;
    /// # let knight = populace::doc_fixture::knight(&mut crowd)?;
    /// # let member = crowd.spawn(knight, Placement::at([0.0; 3]))?;
    /// let (wave, idle) = (crowd.clip(knight, "Wave")?, crowd.clip(knight, "Idle")?);
    /// let mut knight = crowd.member_mut(member)?;
    /// knight.play(wave, ClipPlayback::once())?;
    /// knight.queue(idle, ClipPlayback::looping().fade_in_secs(0.5))?;
    /// crowd.update(1.25)?; // the wave takes one second
    /// let active = crowd.member(member)?.active_clips();
    /// assert_eq!((active[0].clip, active[1].clip), (wave, idle));
    /// assert!((active[1].weight - 0.5).abs() < 1e-3);
    /// # Ok::<(), populace::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// As for [`play`](Self::play).
    pub fn queue(&mut self, clip: ClipId, playback: ClipPlayback) -> Result<PlaybackId, Error> {
        let (player, base) = self.crowd.state.player();
        player.queue(base, self.id, self.character, clip, playback.parts())
    }

    /// Fades layer 0 over to a looping clip within `secs`.
    ///
    /// # Errors
    ///
    /// As for [`play`](Self::play).
    pub fn crossfade(&mut self, clip: ClipId, secs: f32) -> Result<PlaybackId, Error> {
        self.play(clip, ClipPlayback::looping().fade_in_secs(secs))
    }

    /// Fades out everything on a layer and clears its queue. An empty layer 0 shows the rest pose,
    /// any other layer what lies beneath it. Repeating the call does not restart the fade.
    ///
    /// # Errors
    ///
    /// A setting that is out of its range.
    pub fn stop(&mut self, layer: usize, fade_out_secs: f32) -> Result<(), Error> {
        let (player, base) = self.crowd.state.player();
        player.stop(base, self.id, layer, fade_out_secs)
    }

    /// Fades the weight of a clip or a state machine to `weight` within `over_secs`. A weight of 0
    /// ends the playback and frees its slot when the fade is over. Repeating the call does not
    /// restart the fade.
    ///
    /// # Errors
    ///
    /// [`Error::StalePlayback`] for a playback that has ended or is another member's, or a value
    /// that is out of its range.
    pub fn set_weight(
        &mut self,
        playback: PlaybackId,
        weight: f32,
        over_secs: f32,
    ) -> Result<(), Error> {
        self.check_own(playback)?;
        let (player, base) = self.crowd.state.player();
        player.set_weight(base, playback, weight, over_secs)
    }

    /// Sets the speed of a clip from now on; negative plays backwards, 0 holds. The clip queued
    /// after it is rescheduled to the new end, unless the end that it waits for is past. Held
    /// clips, live clips and state machines ignore it.
    ///
    /// # Errors
    ///
    /// [`Error::StalePlayback`] for a playback that has ended or is another member's, or a speed
    /// that is not finite.
    pub fn set_speed(&mut self, playback: PlaybackId, speed: f32) -> Result<(), Error> {
        self.check_own(playback)?;
        let (player, base) = self.crowd.state.player();
        player.set_speed(base, playback, speed)
    }

    fn check_own(&self, playback: PlaybackId) -> Result<(), Error> {
        if playback.member() == self.id { Ok(()) } else { Err(Error::StalePlayback) }
    }

    /// Sets how a layer, 1 to 3, is laid over the layers beneath it: for all joints, or through a
    /// mask. Layer 0 lies over nothing and has no settings.
    ///
    /// # Errors
    ///
    /// A mask of another character, or a layer or setting that is out of its range.
    pub fn set_layer(
        &mut self,
        layer: usize,
        settings: LayerSettings,
        mask: Option<MaskId>,
    ) -> Result<(), Error> {
        let (player, base) = self.crowd.state.player();
        player.set_layer(base, self.id, layer, settings, mask)
    }

    /// Plays a blend space at a position, in place of what the layer plays, which fades out.
    ///
    /// A member plays one blend space at a time. A line takes two slots and a plane three. With
    /// twice as many slots any position is reached at once; with fewer some clips start only when
    /// others have faded out.
    ///
    /// # Errors
    ///
    /// A blend space of another crowd, a setting that is out of its range, a clip that does not
    /// fit the character, or [`Error::BadBlendSpace`] if members have too few slots.
    pub fn play_blend_space(
        &mut self,
        space: BlendSpaceId,
        at: impl Into<SpacePoint>,
        playback: BlendSpacePlayback,
    ) -> Result<(), Error> {
        let (player, base) = self.crowd.state.player();
        player.play_space(base, self.id, space, at.into(), playback.parts())
    }

    /// Moves the member's blend space to another position within `over_secs`. The phase continues
    /// at the speed of the new position. A blend space that fades in arrives no sooner than its
    /// fade ends. Repeating the call changes nothing.
    ///
    /// # Errors
    ///
    /// A value that is out of its range, or [`Error::BadBlendSpace`] if the member plays no blend
    /// space.
    pub fn set_blend_parameter(
        &mut self,
        at: impl Into<SpacePoint>,
        over_secs: f32,
    ) -> Result<(), Error> {
        let (player, base) = self.crowd.state.player();
        player.set_blend_parameter(base, self.id, at.into(), over_secs)
    }

    /// Runs a state machine from its first state, in place of what the layer plays, which fades
    /// out. Anything else that the layer is told to play ends it, and so does
    /// [`stop`](Self::stop).
    ///
    /// A machine takes two slots, and each layer can run one. The device evaluates it: neither
    /// [`active_clips`](Self::active_clips) nor [`Crowd::events`](crate::Crowd::events) tell of its
    /// clips.
    ///
    /// # Errors
    ///
    /// A machine of another crowd, a setting that is out of its range, a clip that does not fit
    /// the character, or [`Error::BadStateMachine`] if members have one slot.
    pub fn play_machine(
        &mut self,
        machine: MachineId,
        playback: MachinePlayback,
    ) -> Result<PlaybackId, Error> {
        let (player, base) = self.crowd.state.player();
        player.run_machine(base, self.id, machine, playback.parts())
    }

    /// Sets a parameter of every state machine that the member runs or has scheduled and that has
    /// this parameter: by name, or by its [id](crate::Crowd::parameter), which is faster. It
    /// uploads 4 bytes.
    ///
    /// # Errors
    ///
    /// A value that is not finite, a parameter of another crowd, or [`Error::BadStateMachine`] if
    /// no machine of the member has such a parameter.
    pub fn set_parameter<'a>(
        &mut self,
        parameter: impl Into<Parameter<'a>>,
        value: f32,
    ) -> Result<(), Error> {
        let (player, base) = self.crowd.state.player();
        player.set_parameter(base, self.id, parameter.into(), value)
    }

    /// Returns the name of the state of a layer's machine after the last update; during a
    /// transition, the state that it leads to. Waits for the device.
    ///
    /// # Errors
    ///
    /// A layer that does not exist, a failing device, or [`Error::BadStateMachine`] if the layer
    /// runs no machine or has only scheduled one.
    pub fn machine_state(&mut self, layer: usize) -> Result<Arc<str>, Error> {
        self.crowd.machine_state(self.id, layer)
    }
}
