//! The arguments of each directive.

use crate::advice::{advice, quoted_after};
use crate::grammar::{Commas, Reader};
use crate::param::Values;
use crate::token::{
    Input, Parsing, SyntaxError, blank, ends_list, found, is_declaration, is_keyword, number, quoted, shown,
    unclosed, word,
};
use crate::{ActiveTransform, Directive, Entity, EntityKind, Spanned, Text};

/// The values of a transformation.
const NUMBERS: Values = Values::Numbers(Vec::new());

impl<'a> Reader<'a> {
    /// Reads the arguments of a keyword.
    pub(crate) fn directive(&mut self, input: Input<'a>, keyword: Input<'a>) -> Parsing<'a, Directive> {
        Ok(match keyword {
            b"Identity" => (input, Directive::Identity),
            b"TransformBegin" => (input, Directive::TransformBegin),
            b"TransformEnd" => (input, Directive::TransformEnd),
            b"AttributeBegin" => (input, Directive::AttributeBegin),
            b"AttributeEnd" => (input, Directive::AttributeEnd),
            b"ObjectEnd" => (input, Directive::ObjectEnd),
            b"ReverseOrientation" => (input, Directive::ReverseOrientation),
            b"WorldBegin" => (input, Directive::WorldBegin),
            b"WorldEnd" => (input, Directive::WorldEnd),
            b"Translate" => self.numbers(input, keyword, Directive::Translate)?,
            b"Scale" => self.numbers(input, keyword, Directive::Scale)?,
            b"Rotate" => self.numbers(input, keyword, Directive::Rotate)?,
            b"LookAt" => self.numbers(input, keyword, Directive::LookAt)?,
            b"Transform" => self.numbers(input, keyword, Directive::Transform)?,
            b"ConcatTransform" => self.numbers(input, keyword, Directive::ConcatTransform)?,
            b"TransformTimes" => self.numbers(input, keyword, Directive::TransformTimes)?,
            b"CoordinateSystem" => self.named(input, keyword, Directive::CoordinateSystem)?,
            b"CoordSysTransform" => self.named(input, keyword, Directive::CoordSysTransform)?,
            b"ObjectBegin" => self.named(input, keyword, Directive::ObjectBegin)?,
            b"ObjectInstance" => self.named(input, keyword, Directive::ObjectInstance)?,
            b"NamedMaterial" => self.named(input, keyword, Directive::NamedMaterial)?,
            b"ActiveTransform" => self.active_transform(input)?,
            b"MediumInterface" => self.medium_interface(input, keyword)?,
            b"Texture" => self.texture(input, keyword)?,
            b"Include" => {
                let (input, file) = self.name(input, keyword)?;
                let (input, rest) = self.params(input);
                (input, Directive::Include { file, rest })
            }
            _ => match EntityKind::ALL.iter().copied().find(|kind| kind.keyword().as_bytes() == keyword) {
                Some(kind) => {
                    let (rest, entity) = self.entity(input, keyword)?;
                    (rest, Directive::Entity(kind, entity))
                }
                None => return self.unknown_directive(keyword).fail(),
            },
        })
    }

    /// Reads the numbers of a transformation. A matrix of 16 numbers needs brackets; fewer numbers need none.
    fn numbers<const N: usize>(
        &mut self,
        input: Input<'a>,
        keyword: Input<'a>,
        directive: fn([f64; N]) -> Directive,
    ) -> Parsing<'a, Directive> {
        let (start, ()) = blank(input)?;
        let open = start.first() == Some(&b'[');
        self.commas = Commas::default();
        let mut input = &start[usize::from(open)..];
        let mut values = [0.0; N];
        for (index, value) in values.iter_mut().enumerate() {
            let before = input;
            (input, _) = self.separator(input)?;
            let new_line = before[..before.len() - input.len()].contains(&b'\n');
            (input, *value) = match number(input) {
                Err(nom::Err::Error(fault) | nom::Err::Failure(fault))
                    if ends_list(fault.at) || index > 0 && new_line && is_word(fault.at) =>
                {
                    self.has_decimal_commas(&NUMBERS);
                    let at = &self.statement[..self.statement.len() - before.len()];
                    return self.miscounted(at, keyword, N, index).fail();
                }
                read => read?,
            };
        }
        let numbers = &start[usize::from(open)..start.len() - input.len()];
        let (rest, more) = self.more_numbers(input)?;
        if !self.has_decimal_commas(&NUMBERS) && more > 0 {
            let (surplus, ()) = blank(input)?;
            let fault = self.miscounted(&surplus[..surplus.len() - rest.len()], keyword, N, N + more);
            self.report(fault);
        }
        input = rest;
        if open {
            (input, _) = self.separator(input)?;
            if input.first() != Some(&b']') {
                return unclosed(&start[..1], input).fail();
            }
            input = &input[1..];
        }
        if open != (N == 16) {
            let all = &start[..start.len() - input.len()];
            self.misbracketed(all, numbers, keyword, open);
        }
        Ok((input, directive(values)))
    }

    fn miscounted(&self, at: Input<'a>, keyword: Input<'a>, wanted: usize, given: usize) -> SyntaxError<'a> {
        let fault = SyntaxError::new(at, format!("{} takes {wanted} numbers, found {given}", shown(keyword)));
        fault.help(match keyword {
            b"Translate" => "write the distances along x, y and z: Translate 0 0 1",
            b"Scale" => "write the factors along x, y and z: Scale 1 1 1",
            b"Rotate" => "write the angle in degrees and the axis: Rotate 45 0 1 0",
            b"LookAt" => "write the eye, the point to look at and the up vector, three numbers each",
            b"TransformTimes" => "write the start time and the end time",
            _ => "write the matrix column by column",
        })
    }

    /// Skips and counts the following numbers.
    pub(crate) fn more_numbers(&mut self, input: Input<'a>) -> Parsing<'a, usize> {
        let (mut input, mut count) = (input, 0);
        loop {
            let (next, ()) = self.separator(input)?;
            let Ok((rest, _)) = number(next) else { return Ok((input, count)) };
            (input, count) = (rest, count + 1);
        }
    }

    /// Reads the one argument of a directive that takes a name.
    fn named(
        &mut self,
        input: Input<'a>,
        keyword: Input<'a>,
        directive: fn(Text) -> Directive,
    ) -> Parsing<'a, Directive> {
        let (rest, name) = self.name(input, keyword)?;
        Ok((rest, directive(name)))
    }

    fn name(&mut self, input: Input<'a>, keyword: Input<'a>) -> Parsing<'a, Text> {
        let (input, ()) = blank(input)?;
        let (what, example) = quoted_after(keyword);
        // The keyword as written, which may be misspelled.
        let (_, here) = word(self.statement)?;
        let missing = || {
            SyntaxError::new(here, format!("a quoted {what} is missing after {}", shown(keyword)))
                .help(format!("write it like {example}"))
        };
        if what == "type" && is_declaration(input) {
            return missing().fail();
        }
        if input.first() == Some(&b'"') {
            return self.closed_string(input);
        }
        if let Some(read) = self.unopened_string(input) {
            return Ok(read);
        }
        if let Some(next) = self.surplus_word(input, keyword) {
            return self.closed_string(next);
        }
        let (at, found) = found(input);
        if is_keyword(at) {
            if keyword != b"ObjectBegin" {
                return missing().fail();
            }
            // The following directives still belong to the object.
            self.report(missing());
            return Ok((input, Spanned { value: String::new(), span: self.span(here) }));
        }
        let fault =
            SyntaxError::new(at, format!("expected a quoted {what} after {}, found {found}", shown(keyword)));
        // A bare word that is not a keyword is a name without its quotes.
        let text = shown(at);
        if at.first().is_some_and(u8::is_ascii_alphabetic) {
            self.report(fault.help("put it in quotes").replace_with(format!("\"{text}\"")));
            return Ok((&input[at.len()..], Spanned { value: text, span: self.span(at) }));
        }
        match advice(at) {
            Some(advice) => fault.help(advice).fail(),
            None => fault.help(format!("write it like {example}")).fail(),
        }
    }

    pub(crate) fn string(&self, input: Input<'a>) -> Parsing<'a, Text> {
        let (rest, value) = quoted(input)?;
        Ok((rest, Spanned { value, span: self.span(&input[..input.len() - rest.len()]) }))
    }

    fn active_transform(&mut self, input: Input<'a>) -> Parsing<'a, Directive> {
        let (input, ()) = blank(input)?;
        let (at, found) = found(input);
        let which = match at {
            b"All" => ActiveTransform::All,
            b"StartTime" => ActiveTransform::StartTime,
            b"EndTime" => ActiveTransform::EndTime,
            _ => {
                let message =
                    format!("expected All, StartTime or EndTime after ActiveTransform, found {found}");
                return SyntaxError::new(at, message).fail();
            }
        };
        Ok((&input[at.len()..], Directive::ActiveTransform(which)))
    }

    fn medium_interface(&mut self, input: Input<'a>, keyword: Input<'a>) -> Parsing<'a, Directive> {
        let (input, inside) = self.name(input, keyword)?;
        let (next, ()) = blank(input)?;
        if next.first() != Some(&b'"') {
            return Ok((input, Directive::MediumInterface { inside, outside: None }));
        }
        let (input, outside) = self.string(next)?;
        Ok((input, Directive::MediumInterface { inside, outside: Some(outside) }))
    }

    fn texture(&mut self, input: Input<'a>, keyword: Input<'a>) -> Parsing<'a, Directive> {
        let (input, name) = self.name(input, keyword)?;
        let (input, value) = self.name(input, b"the name of a Texture")?;
        let (input, entity) = self.entity(input, b"the value type of a Texture")?;
        Ok((input, Directive::Texture { name, value, entity }))
    }

    pub(crate) fn entity(&mut self, input: Input<'a>, keyword: Input<'a>) -> Parsing<'a, Entity> {
        let (input, name) = self.name(input, keyword)?;
        let (input, params) = self.params(input);
        Ok((input, Entity { name, params }))
    }
}

/// True for a word, such as a misspelled directive, that is not meant as a number.
fn is_word(at: Input) -> bool {
    let lower = at.to_ascii_lowercase();
    at.first().is_some_and(u8::is_ascii_alphabetic)
        && !lower.starts_with(b"nan")
        && !lower.starts_with(b"inf")
}
