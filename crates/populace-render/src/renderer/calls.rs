//! Draw calls: meshes and instances that are drawn with the same state.

use std::collections::{BTreeMap, HashMap};
use std::ops::Range;
use std::rc::Rc;

use crate::batch::Run;
use crate::gl::{Buffer, Cull, DrawCommand, DrawCommands, Texture};
use crate::layout::Surface;
use crate::model::{Alpha, Model, ModelLevel, ModelPart};
use crate::programs::{Kind, MemberKind};

/// A pass over the members.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Pass {
    Shadow,
    Opaque {
        /// Contact shadows lie on members.
        on_members: bool,
    },
    /// Depth of what hides members, by the shaders of `Opaque`.
    Hiding {
        on_members: bool,
    },
    /// Blended parts, whose order counts.
    Blended,
    /// Depth and number of members.
    Marks,
}

/// One draw call.
pub(super) struct Call {
    pub(super) kind: Kind,
    pub(super) cull: Cull,
    /// Page of the palettes.
    pub(super) page: usize,
    /// Model, level and part with the material and the textures of the whole call.
    pub(super) part: [usize; 3],
    pub(super) commands: Range<usize>,
}

/// Properties that draws of one call have in common.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
struct State {
    /// Places are drawn last: see `Group` of `batch.rs`.
    is_place: bool,
    page: usize,
    kind: Kind,
    cull: Cull,
    /// Material and textures; null where the shader reads none.
    surface: *const Buffer<Surface>,
    textures: [*const Texture; 5],
}

impl Pass {
    /// Returns true if parts with this alpha mode are drawn.
    fn draws(self, alpha: Alpha) -> bool {
        match self {
            Self::Shadow | Self::Opaque { .. } | Self::Hiding { .. } => alpha != Alpha::Blended,
            Self::Blended => alpha == Alpha::Blended,
            Self::Marks => true,
        }
    }

    /// Returns true if contact shadows lie on the members that are drawn.
    fn reads_contacts(self) -> bool {
        matches!(self, Self::Opaque { on_members: true } | Self::Hiding { on_members: true })
    }

    /// Returns the shader variant of a part.
    fn kind(self, level: &ModelLevel, part: &ModelPart, faded: bool) -> Kind {
        let &ModelPart { alpha, influences, .. } = part;
        let textured = part.texture.is_some();
        // Shaders that write no colours read textures for their alpha.
        let has_alpha = textured && alpha != Alpha::Opaque;
        let vertex_lit = level.is_coarse;
        match self {
            Self::Shadow => Kind::Shadow { influences, alpha, textured: has_alpha },
            Self::Marks => Kind::Marks { influences, alpha, textured: has_alpha, faded },
            Self::Opaque { .. } | Self::Hiding { .. } | Self::Blended => Kind::Member(MemberKind {
                influences,
                alpha,
                textured,
                vertex_lit,
                two_sided: vertex_lit && part.double_sided,
                faded,
                contacts: !vertex_lit && self.reads_contacts(),
                maps: part.sampled_maps(),
            }),
        }
    }
}

impl State {
    fn of(run: &Run, model: &Model, part: &ModelPart, kind: Kind) -> Self {
        let writes_colors = matches!(kind, Kind::Member(_));
        let reads_material = writes_colors || part.alpha != Alpha::Opaque;
        let texture = |texture: &Option<Rc<Texture>>, is_read| {
            texture.as_ref().filter(|_| is_read).map_or(std::ptr::null(), Rc::as_ptr)
        };
        let [substance, normal, occlusion, emissive] =
            part.maps.each_ref().map(|map| texture(map, writes_colors));
        let color = texture(&part.texture, reads_material);
        Self {
            is_place: model.info.is_place,
            page: run.page,
            kind,
            cull: part.cull(run.mirrored),
            surface: if reads_material { Rc::as_ptr(&part.surface) } else { std::ptr::null() },
            textures: [color, substance, normal, occlusion, emissive],
        }
    }
}

/// Returns the calls that draw `runs`, and appends their commands. Draws with the same state are
/// one call, in the place of the first of them. Blended parts keep their order.
pub(super) fn calls(
    runs: &[Run],
    pass: Pass,
    models: &[Model],
    commands: &mut DrawCommands,
) -> Vec<Call> {
    let mut groups: Vec<(Call, Vec<DrawCommand>)> = Vec::new();
    let mut known: HashMap<State, usize> = HashMap::new();
    for run in runs {
        let model = &models[run.model];
        let level = &model.levels[run.level as usize];
        let parts = level.parts.iter().enumerate();
        for (index, part) in parts.filter(|(_, part)| pass.draws(part.alpha)) {
            let kind = pass.kind(level, part, run.faded);
            let state = State::of(run, model, part, kind);
            if pass == Pass::Blended && !known.contains_key(&state) {
                known.clear();
            }
            let group = *known.entry(state).or_insert_with(|| {
                let part = [run.model, run.level as usize, index];
                let call = Call { kind, cull: state.cull, page: run.page, part, commands: 0..0 };
                groups.push((call, Vec::new()));
                groups.len() - 1
            });
            groups[group].1.push(part.mesh.command(run.first, run.count));
        }
    }
    let with_commands =
        |(call, list): (Call, Vec<_>)| Call { commands: commands.extend(&list), ..call };
    groups.into_iter().map(with_commands).collect()
}

/// Returns the calls that draw the contact shadows of `runs`, each with its page, and appends their
/// commands.
pub(super) fn contact_calls(
    runs: &[Run],
    models: &[Model],
    commands: &mut DrawCommands,
) -> Vec<(usize, Range<usize>)> {
    let mut pages: BTreeMap<usize, Vec<DrawCommand>> = BTreeMap::new();
    for run in runs {
        let model = &models[run.model];
        let is_coarse = model.levels[run.level as usize].is_coarse;
        if let Some(command) = model.contacts.command(is_coarse, run.first, run.count) {
            pages.entry(run.page).or_default().push(command);
        }
    }
    pages.into_iter().map(|(page, list)| (page, commands.extend(&list))).collect()
}
