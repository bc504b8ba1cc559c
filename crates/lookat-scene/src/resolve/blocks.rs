//! Blocks: the place of each directive, opening and closing, and objects.

use std::collections::HashMap;

use lookat_syntax::{ActiveTransform, Diagnostic, Directive, EntityKind, Span, Statement, Text};

use crate::draft::Placed;
use crate::facts::{Block, BlockKind, BlockStart};
use crate::options::ResolvedOptions;
use crate::resolve::{GraphicsState, Resolver};
use crate::symbols::SymbolKind;
use crate::transform::{Transform, TransformSet};

/// The deepest nesting of blocks.
const MAX_OPEN: usize = 1000;

impl Resolver<'_> {
    /// Reports a directive in the wrong block.
    pub(super) fn belongs_here(&mut self, statement: &Statement) -> bool {
        let (home, at) = (home_block(&statement.directive), statement.keyword);
        let keyword = statement.directive.keyword();
        match (home, self.block) {
            (_, Block::Ended) => {
                let message = "lookat ignores directives after WorldEnd: it renders one picture per file";
                self.report.unsupported(at, message.into());
            }
            (Some(Block::Options), Block::World) => self.report_late(&statement.directive, at),
            // Reported once the place of WorldBegin is known.
            (Some(Block::World), Block::Options) => self.facts.early.push((keyword, at)),
            _ => return true,
        }
        false
    }

    pub(super) fn report_late(&mut self, directive: &Directive, at: Span) {
        let error = match directive {
            Directive::WorldBegin => {
                Diagnostic::error(at, "a second WorldBegin").help("put the second world into a separate file")
            }
            other => Diagnostic::error(at, format!("{} inside the world block", other.keyword()))
                .help("move it before WorldBegin"),
        };
        let error = match self.facts.world_begin {
            Some(begin) => error.related(begin, "the world block begins here"),
            None => error,
        };
        self.report.push(error);
    }

    /// Treats the file as a part of a world, or of options if the caller accepts that. Another file may define its names.
    pub fn begin_part(&mut self, block: Block, first: Span) {
        if block == Block::World || self.load_options.accept_part {
            self.block = block;
            self.facts.part = Some((block, first));
            self.report.incomplete = true;
        }
    }

    /// Resolves the options. They end at `end`.
    pub(super) fn resolve_options(&mut self, end: Span) -> ResolvedOptions {
        let options = std::mem::take(&mut self.options);
        options.resolve(end, self.load_options, &self.files, &mut self.report, &mut self.facts)
    }

    pub(super) fn world_begin(&mut self, at: Span) {
        self.block = Block::World;
        self.facts.world_begin = Some(at);
        for (keyword, early) in &self.facts.early {
            let error = Diagnostic::error(*early, format!("{keyword} before WorldBegin"))
                .help("move it after WorldBegin")
                .related(at, "the world block begins here");
            self.report.push(error);
        }
        self.state.ctm = TransformSet::still(Transform::IDENTITY);
        self.state.projective = None;
        self.state.active = ActiveTransform::All;
        self.state.active_since = None;
        self.definitions.coordinate_systems.define_builtin("world", self.state.ctm.clone().into());
        self.resolved = Some(self.resolve_options(at));
    }

    pub(super) fn world_end(&mut self) {
        self.end_forgotten_object();
        for open in std::mem::take(&mut self.blocks.open).into_iter().rev() {
            self.facts.unclosed.push(open.start);
            self.restore(open);
        }
        self.facts.active = self.state.active_since;
        if self.resolved.as_ref().is_some_and(|resolved| resolved.passes_boundaries) {
            // As in pbrt-v3, which makes the camera here.
            self.draft.camera_medium = self.state.medium.outside;
        } else {
            self.draft.media.clear();
        }
        self.block = Block::Ended;
    }

    /// Opens a block, unless the nesting is too deep.
    pub(super) fn begin(&mut self, kind: BlockKind, at: Span, name: Option<Text>) -> bool {
        let few = self.blocks.open.len() < MAX_OPEN;
        if few {
            let saved = Box::new(self.state.clone());
            self.blocks.open.push(Open { start: BlockStart { kind, at }, saved, name });
        } else {
            let (begin, end) = kind.keywords();
            let error = Diagnostic::error(at, format!("more than {MAX_OPEN} blocks are open"))
                .help(format!("each {begin} needs an {end}: add the missing one"));
            self.report.push(error);
            *self.blocks.unmatched_ends.entry(kind).or_default() += 1;
        }
        few
    }

    pub(super) fn close(&mut self, kind: BlockKind, at: Span) -> Result<(), Box<Diagnostic>> {
        let (begin, keyword) = kind.keywords();
        let Some(inner) = self.blocks.open.last().map(|open| open.start) else {
            if let Some(count) = self.blocks.unmatched_ends.get_mut(&kind).filter(|count| **count > 0) {
                *count -= 1;
                return Ok(());
            }
            return Diagnostic::error(at, format!("{keyword} without {begin}")).fail();
        };
        if inner.kind == kind {
            if let Some(open) = self.blocks.open.pop() {
                self.restore(open);
            }
            return Ok(());
        }
        if self.close_outer(kind) {
            // The end of an open object shows the actual mistake.
            match kind {
                BlockKind::Attribute => self.blocks.early_end = self.blocks.early_end.or(Some(at)),
                _ => self.report_overlapping(keyword, at, inner),
            }
            return Ok(());
        }
        let (begin, end) = inner.kind.keywords();
        self.close_wrongly(kind);
        Diagnostic::error(at, format!("{keyword} inside the block of {begin}"))
            .note(format!("expected {end}"))
            .related(inner.at, "the block opens here")
            .fail()
    }

    /// Warns of an end that closes a block although `inner` is still open inside the block.
    fn report_overlapping(&mut self, keyword: &str, at: Span, inner: BlockStart) {
        let (begin, end) = inner.kind.keywords();
        let help = format!(
            "as in pbrt-v3, this closes the outer block and leaves the inner block open: write {end} before this directive"
        );
        let warning = Diagnostic::warning(at, format!("{keyword} inside the block of {begin}"));
        self.report.push(warning.related(inner.at, "the block opens here").help(help));
    }

    /// Ends the innermost block of a kind although other attribute or object blocks are open inside it. pbrt-v3 keeps
    /// their states on one stack, so the state saved last is restored first.
    fn close_outer(&mut self, kind: BlockKind) -> bool {
        let Some(at) = self.blocks.open.iter().rposition(|open| open.start.kind == kind) else {
            return false;
        };
        if self.blocks.open[at..].iter().any(|open| open.start.kind == BlockKind::Transform) {
            return false;
        }
        for next in at + 1..self.blocks.open.len() {
            if let [outer, inner] = &mut self.blocks.open[next - 1..=next] {
                std::mem::swap(&mut outer.saved, &mut inner.saved);
                std::mem::swap(outer, inner);
            }
        }
        if let Some(open) = self.blocks.open.pop() {
            self.restore(open);
        }
        true
    }

    /// Recovers from a wrong end with one error: closes blocks up to a matching one. Without a match, closes the
    /// innermost block, unless the block or the keyword belongs to an object.
    fn close_wrongly(&mut self, kind: BlockKind) {
        let depth = match self.blocks.open.iter().rposition(|open| open.start.kind == kind) {
            Some(matching) => matching,
            None if kind == BlockKind::Object || self.blocks.open.last().is_some_and(Open::is_object) => {
                return;
            }
            None => self.blocks.open.len() - 1,
        };
        for open in self.blocks.open.split_off(depth).into_iter().rev() {
            if open.start.kind != kind {
                *self.blocks.unmatched_ends.entry(open.start.kind).or_default() += 1;
            }
            self.restore(open);
        }
    }

    pub(super) fn restore(&mut self, Open { start, saved, name }: Open) {
        match start.kind {
            BlockKind::Transform => {
                (self.state.ctm, self.state.active) = (saved.ctm, saved.active);
                self.state.projective = saved.projective;
            }
            BlockKind::Attribute => self.state = *saved,
            BlockKind::Object => {
                if let Some(at) = self.blocks.early_end.take() {
                    self.report_overlapping("AttributeEnd", at, start);
                }
                self.state = *saved;
                if let (Some(name), Some(object)) = (name, self.draft.open) {
                    self.draft.open = None;
                    self.define_object(name, object, start.at);
                }
            }
        }
    }
}

/// The block of a directive. `None` if it may appear in both.
pub(crate) fn home_block(directive: &Directive) -> Option<Block> {
    match directive {
        Directive::WorldBegin | Directive::TransformTimes(_) => Some(Block::Options),
        Directive::Entity(kind, _) => match kind {
            EntityKind::Camera
            | EntityKind::Film
            | EntityKind::PixelFilter
            | EntityKind::Sampler
            | EntityKind::Integrator
            | EntityKind::Accelerator => Some(Block::Options),
            EntityKind::MakeNamedMedium => None,
            _ => Some(Block::World),
        },
        Directive::AttributeBegin
        | Directive::AttributeEnd
        | Directive::TransformBegin
        | Directive::TransformEnd
        | Directive::ObjectBegin(_)
        | Directive::ObjectEnd
        | Directive::ObjectInstance(_)
        | Directive::ReverseOrientation
        | Directive::NamedMaterial(_)
        | Directive::Texture { .. }
        | Directive::WorldEnd => Some(Block::World),
        _ => None,
    }
}

impl Resolver<'_> {
    pub(super) fn define_object(&mut self, name: Text, object: usize, at: Span) {
        let is_empty = |object: usize| self.draft.objects[object].is_empty();
        let known = self.definitions.objects.get(&name.value).filter(|known| !is_empty(**known));
        if known.is_some() && !name.value.is_empty() {
            self.facts.redefined.push((SymbolKind::Object, name.value.clone(), at));
        }
        let symbol = self.definitions.objects.define(&name, object, &mut self.report);
        if !is_empty(object) {
            self.facts.objects.push((at, symbol));
        }
    }

    pub(super) fn object_begin(&mut self, name: Text, at: Span) -> Result<(), Box<Diagnostic>> {
        self.end_forgotten_object();
        let Some(outer) = self.open_object() else {
            if self.begin(BlockKind::Object, at, Some(name)) {
                self.draft.open = Some(self.draft.new_object());
            }
            return Ok(());
        };
        // Its ObjectEnd and its instances are not errors.
        self.begin(BlockKind::Object, at, None);
        if self.definitions.objects.get(&name.value).is_none() {
            self.definitions.objects.define(&name, self.draft.new_object(), &mut self.report);
        }
        Diagnostic::error(at, "ObjectBegin inside the definition of an object")
            .related(outer, "the outer object begins here")
            .fail()
    }

    pub(super) fn object_instance(&mut self, name: Text) -> Result<(), Box<Diagnostic>> {
        self.end_forgotten_object();
        if let Some(outer) = self.open_object() {
            return Diagnostic::error(name.span, "ObjectInstance inside the definition of an object")
                .related(outer, "the object begins here")
                .fail();
        }
        self.need_affine(name.span);
        let motion = self.motion(name.span)?;
        if let Some(object) = self.definitions.objects.find(&name, &mut self.report) {
            let ctm = self.state.ctm.start.clone();
            self.draft.world.instances.push(Placed { object: *object, ctm, motion });
        }
        Ok(())
    }

    /// The place of the outermost open object.
    fn open_object(&self) -> Option<Span> {
        self.blocks.open.iter().find(|open| open.is_object()).map(|open| open.start.at)
    }

    /// Ends an object that an AttributeEnd ended early and no ObjectEnd closed, and reports the missing ObjectEnd.
    pub(super) fn end_forgotten_object(&mut self) {
        if self.blocks.early_end.is_none() || !self.blocks.open.last().is_some_and(Open::is_object) {
            return;
        }
        if let (Some(at), Some(open)) = (self.blocks.early_end.take(), self.blocks.open.pop()) {
            let error = Diagnostic::error(at, "ObjectEnd is missing before this AttributeEnd");
            self.report.push(error.related(open.start.at, "the object begins here"));
            self.restore(open);
        }
    }
}

/// The open blocks.
#[derive(Default)]
pub(crate) struct Blocks {
    pub open: Vec<Open>,
    /// The first AttributeEnd in the open object that closes a block around the object.
    pub early_end: Option<Span>,
    /// Unmatched end directives, counted so that each is reported once.
    pub unmatched_ends: HashMap<BlockKind, usize>,
}

/// An open block.
pub(crate) struct Open {
    pub start: BlockStart,
    /// The state that its end restores.
    pub saved: Box<GraphicsState>,
    /// The name of an object. `None` if the object is nested, which is an error.
    pub name: Option<Text>,
}

impl Open {
    pub fn is_object(&self) -> bool {
        self.start.kind == BlockKind::Object
    }
}
