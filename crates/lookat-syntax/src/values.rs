//! The grammar of parameters and their values.

use crate::grammar::{Reader, is_keyword};
use crate::param::{Param, ParamType, Values};
use crate::token::{Fault, Input, Parsing, blank, found, number, quoted, separator, shown};
use crate::{Diagnostic, Spanned, Text, nearest};

/// At most this many bad values are reported of one list.
const FAULTS_PER_LIST: usize = 5;

impl<'a> Reader<'a> {
    pub(crate) fn params(&mut self, input: Input<'a>) -> Parsing<'a, Vec<Param>> {
        let mut params = Vec::new();
        let mut input = input;
        loop {
            let (next, ()) = blank(input)?;
            if next.first() != Some(&b'"') {
                return Ok((input, params));
            }
            let (rest, declaration) = self.string(next)?;
            let (rest, param) = self.param(rest, declaration)?;
            params.extend(param);
            input = rest;
        }
    }

    /// The values after a declaration. A parameter that cannot be read is reported and left out.
    fn param(&mut self, input: Input<'a>, declaration: Text) -> Parsing<'a, Option<Param>> {
        let declared = self.declaration(&declaration);
        let (input, ()) = blank(input)?;
        let start = input;
        let list = input.first() == Some(&b'[');
        let mut values = self.empty(declared.as_ref().map(|(ty, _)| *ty), &input[usize::from(list)..]);
        let faults_before = self.diagnostics.len();
        let (input, count) = if list {
            self.list(&input[1..], &input[..1], &mut values)?
        } else {
            (self.value(input, &mut values, 0)?.0, 1)
        };
        let span = self.between(start, input);
        let Some((ty, name)) = declared else { return Ok((input, None)) };
        if self.diagnostics.len() > faults_before {
            return Ok((input, None));
        }
        if count % ty.arity() != 0 {
            let noun = ["", "pairs", "threes"][ty.arity() - 1];
            let help = if list {
                "".into()
            } else {
                format!("several values stand in brackets: \"{} {name}\" [...]", ty.name())
            };
            let mut error = Diagnostic::error(
                span,
                format!("a {} takes its numbers in {noun}; {count} given", ty.name()),
            );
            error.help = (!list).then_some(help);
            self.diagnostics.push(error);
            self.faulty = true;
            return Ok((input, None));
        }
        let name = Spanned { value: name, span: declaration.span };
        Ok((input, Some(Param { ty, name, values: Spanned { value: values, span } })))
    }

    /// Splits `"float radius"`; reports what is no declaration.
    fn declaration(&mut self, declaration: &Text) -> Option<(ParamType, String)> {
        let mut words = declaration.value.split([' ', '\t']).filter(|word| !word.is_empty());
        let (ty, name) = (words.next(), words.next());
        let at = declaration.span;
        self.faulty = true;
        let error = match (ty, name) {
            (Some(ty), Some(name)) => match ParamType::from_spelling(ty) {
                Some(ty) => {
                    self.faulty = false;
                    return Some((ty, name.into()));
                }
                None => {
                    let error = Diagnostic::error(at, format!("unknown parameter type `{ty}`"));
                    match nearest(ty, ParamType::SPELLINGS.map(|(spelling, _)| spelling)) {
                        Some(known) => error
                            .help(format!("did you mean `{known}`?"))
                            .fix(at, format!("\"{known} {name}\"")),
                        None => error.help("a parameter is declared by its type and its name: \"float fov\""),
                    }
                }
            },
            (Some(only), None) => Diagnostic::error(at, format!("\"{only}\" does not declare a parameter"))
                .help("a parameter is declared by its type and its name in one string: \"float fov\""),
            _ => Diagnostic::error(at, "an empty parameter declaration")
                .help("a parameter is declared by its type and its name in one string: \"float fov\""),
        };
        self.diagnostics.push(error);
        None
    }

    /// An empty list of the right shape; of an undeclared type, the one that the first value asks for.
    fn empty(&self, ty: Option<ParamType>, input: Input<'a>) -> Values {
        let quoted = blank(input).is_ok_and(|(input, ())| input.first() == Some(&b'"'));
        match ty {
            Some(ParamType::Integer) => Values::Integers(Vec::new()),
            Some(ParamType::Bool) => Values::Bools(Vec::new()),
            Some(ParamType::String | ParamType::Texture) => Values::Strings(Vec::new()),
            Some(ParamType::Spectrum) | None if quoted => Values::Strings(Vec::new()),
            Some(ty) if ty.arity() == 2 => Values::Pairs(Vec::new()),
            Some(ty) if ty.arity() == 3 => Values::Triples(Vec::new()),
            _ => Values::Numbers(Vec::new()),
        }
    }

    /// The values up to the closing bracket, and how many there are.
    fn list(&mut self, input: Input<'a>, open: Input<'a>, values: &mut Values) -> Parsing<'a, usize> {
        let mut input = input;
        let (mut count, mut faults) = (0, 0);
        loop {
            (input, _) = self.separator(input)?;
            match input.first() {
                Some(b']') => return Ok((&input[1..], count)),
                None => {
                    return Fault::new(open, "the file ends inside this list")
                        .help("add the closing `]`")
                        .fail();
                }
                _ => {}
            }
            match self.value(input, values, count) {
                Ok((rest, ())) => input = rest,
                Err(nom::Err::Error(fault) | nom::Err::Failure(fault)) => {
                    let word = fault.at;
                    // After an open quote nothing is certain; a directive means that the bracket was forgotten.
                    if word.is_empty() || is_keyword(word) || fault.message.contains("closed") || word == b"["
                    {
                        return Fault::new(open, "this list is not closed")
                            .help(format!("add `]` before {}", found(input).1))
                            .fail();
                    }
                    faults += 1;
                    if faults <= FAULTS_PER_LIST {
                        self.report(fault);
                    }
                    let skipped = self.offset(word) - self.offset(input) + word.len();
                    input = &input[skipped.max(1)..];
                }
                Err(incomplete) => return Err(incomplete),
            }
            count += 1;
        }
    }

    /// One value, appended to a list of its kind. `index` counts the numbers of points one by one.
    fn value(&mut self, input: Input<'a>, values: &mut Values, index: usize) -> Parsing<'a, ()> {
        match values {
            Values::Numbers(list) => {
                let (rest, value) = number(input)?;
                list.push(value);
                Ok((rest, ()))
            }
            Values::Pairs(list) => push_component(list, number(input)?, index),
            Values::Triples(list) => push_component(list, number(input)?, index),
            Values::Integers(list) => {
                let (rest, value) = self.integer(input)?;
                list.push(value);
                Ok((rest, ()))
            }
            Values::Bools(list) => {
                let (rest, value) = boolean(input)?;
                list.push(value);
                Ok((rest, ()))
            }
            Values::Strings(list) => {
                if input.first() != Some(&b'"') {
                    let (at, found) = found(input);
                    return Fault::new(at, format!("expected a quoted string, found {found}")).fail();
                }
                let (rest, text) = self.string(input)?;
                list.push(text);
                Ok((rest, ()))
            }
        }
    }

    fn integer(&mut self, input: Input<'a>) -> Parsing<'a, i32> {
        let (rest, value) = number(input)?;
        let at = &input[..input.len() - rest.len()];
        if value < f64::from(i32::MIN) || value > f64::from(i32::MAX) {
            return Fault::new(at, format!("{} does not fit an integer", shown(at)))
                .help("integers reach from -2147483648 to 2147483647")
                .fail();
        }
        if value.fract() != 0.0 {
            let warning = Diagnostic::warning(self.span(at), format!("{} is not an integer", shown(at)))
                .help(format!("pbrt-v3 drops the fraction: {}", value.trunc()));
            self.diagnostics.push(warning);
        }
        Ok((rest, value as i32))
    }

    pub(crate) fn separator(&mut self, input: Input<'a>) -> Parsing<'a, ()> {
        let (rest, comma) = separator(input)?;
        if comma && self.comma.is_none() {
            let at = input.iter().position(|byte| *byte == b',').unwrap_or(0);
            self.comma = Some(self.span(&input[at..=at]));
        }
        Ok((rest, ()))
    }
}

/// Appends one number to a list of pairs or triples.
fn push_component<'a, const N: usize>(
    list: &mut Vec<[f64; N]>,
    (rest, value): (Input<'a>, f64),
    index: usize,
) -> Parsing<'a, ()> {
    match list.last_mut() {
        Some(last) if !index.is_multiple_of(N) => last[index % N] = value,
        _ => list.push([value; N]),
    }
    Ok((rest, ()))
}

fn boolean(input: Input) -> Parsing<bool> {
    if input.first() == Some(&b'"') {
        let (rest, text) = quoted(input)?;
        let at = &input[..input.len() - rest.len()];
        return match text.as_str() {
            "true" => Ok((rest, true)),
            "false" => Ok((rest, false)),
            _ => Fault::new(at, format!("a bool is \"true\" or \"false\", not \"{text}\"")).fail(),
        };
    }
    let (at, found) = found(input);
    let fault = Fault::new(at, format!("expected \"true\" or \"false\", found {found}"));
    if matches!(at, b"true" | b"false") {
        return fault.help("bools are quoted").replace_with(format!("\"{}\"", shown(at))).fail();
    }
    fault.fail()
}
