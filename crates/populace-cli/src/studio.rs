//! Pictures of a crowd: the renderer, and files to write them to.

use std::fs::OpenOptions;
use std::path::{Path, PathBuf};

use populace::core::{Image, Part};
use populace::{Crowd, CrowdBuilder};
use populace_render::{Camera, CharacterHandle, HandOver, Instance, Renderer, Scene, write_png};

use crate::cast::Role;
use crate::failure::Failure;

/// A renderer that knows a crowd's characters.
pub(crate) struct Studio {
    renderer: Renderer,
    handles: Vec<CharacterHandle>,
    scene: Scene,
    hand_over: HandOver,
}

impl Studio {
    /// Links the crowd's palettes to the renderer; `crowd` should have been built for its OpenGL.
    pub(crate) fn new(
        mut renderer: Renderer,
        crowd: &mut Crowd,
        roles: &[Role],
        hide: &[String],
        camera: Camera,
    ) -> Result<Self, Failure> {
        let hand_over = renderer.link_palettes(crowd)?;
        let hidden = |part: &Part| hide.contains(&part.node_name);
        let handles = roles.iter().map(|role| renderer.add_character(&role.character, &hidden));
        let handles = handles.collect::<Result<_, _>>()?;
        Ok(Self { renderer, handles, scene: Scene { camera, ..Scene::default() }, hand_over })
    }

    /// What draws, and how palettes get there, for people.
    pub(crate) fn driver(&self) -> String {
        format!("{}, palettes {}", self.renderer.driver(), self.hand_over.way)
    }

    /// Draws the crowd as of its last update.
    pub(crate) fn picture(&mut self, crowd: &mut Crowd) -> Result<Image, Failure> {
        self.renderer.take_palettes(crowd)?;
        let instances: Vec<_> = crowd
            .instances()
            .map(|i| Instance {
                character: self.handles[i.character.index()],
                world_from_model: i.world_from_model,
                moved: i.moved,
                palette_first: i.palette_first,
                tint: [1.0; 3],
            })
            .collect();
        self.renderer.draw(&self.scene, &instances)?;
        Ok(self.renderer.read_image()?)
    }

    /// Draws the crowd and writes the picture.
    pub(crate) fn shoot(&mut self, crowd: &mut Crowd, path: &Path) -> Result<(), Failure> {
        Ok(write_png(path, &self.picture(crowd)?)?)
    }
}

/// A crowd to be built for the OpenGL of a renderer, where there is one.
pub(crate) fn drawn_with(
    builder: CrowdBuilder,
    renderer: &Result<Renderer, populace_render::Error>,
) -> CrowdBuilder {
    match renderer {
        Ok(renderer) => builder.for_gl(renderer.gl_context()),
        Err(_) => builder,
    }
}

/// The devices of a crowd by name, and the share of each where there are several.
pub(crate) fn devices_and_shares(crowd: &Crowd) -> String {
    let (devices, shares) = (crowd.devices().as_slice(), crowd.shares());
    match devices {
        [only] => only.to_string(),
        _ => {
            let part = |(device, share)| format!("{device} ({:.0} %)", share * 100.0);
            devices.iter().zip(shares).map(part).collect::<Vec<_>>().join(" + ")
        }
    }
}

/// Refuses names of files of another kind, as they were typed.
pub(crate) fn check_kind(path: &Path, kind: &str) -> Result<(), Failure> {
    if path.extension().is_some_and(|e| e.eq_ignore_ascii_case(kind)) {
        return Ok(());
    }
    let (path, kind_name) = (path.display(), kind.to_uppercase());
    Err(Failure::usage(format!("{path} does not end in .{kind}, and {kind_name} is what is written")))
}

/// Opens the output before the work, so that a wrong path costs no waiting; what stands there is left as it is.
pub(crate) fn check_output(path: &Path, kind: &str) -> Result<(), Failure> {
    check_kind(path, kind)?;
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty() && !folder.exists());
    if let Some(folder) = folder {
        let (path, folder) = (path.display(), folder.display());
        return Err(Failure::Run(anyhow::anyhow!(
            "cannot write {path}: there is no folder {folder}; create it first"
        )));
    }
    // A link counts as standing there, even one that leads nowhere yet.
    let existed = path.symlink_metadata().is_ok();
    let opened = OpenOptions::new().append(true).create(true).open(path);
    opened.map_err(|e| Failure::Run(anyhow::anyhow!("cannot write {}: {e}", path.display())))?;
    if !existed {
        std::fs::remove_file(path)?;
    }
    Ok(())
}

/// Where frame `index` of a film goes: `crowd.png` becomes `crowd_0007.png`.
pub(crate) fn frame_path(path: &Path, index: u32) -> PathBuf {
    let part = |part: Option<&std::ffi::OsStr>| part.unwrap_or_default().to_string_lossy().into_owned();
    let (stem, extension) = (part(path.file_stem()), part(path.extension()));
    path.with_file_name(format!("{stem}_{index:04}.{extension}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_numbered_beside_the_name() {
        assert_eq!(frame_path(Path::new("a/crowd.png"), 7), Path::new("a/crowd_0007.png"));
        assert_eq!(frame_path(Path::new("b.c.png"), 12345), Path::new("b.c_12345.png"));
    }
}
