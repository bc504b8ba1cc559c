//! The grammar of parameters and their values.

use crate::grammar::{Commas, PARAM_BYTES, Reader, STRING_BYTES};
use crate::param::{Param, ParamType, Values};
use crate::recovery::unopened;
use crate::token::{
    Input, Parsing, SyntaxError, blank, ends_list, found, is_declaration, is_delimiter, number, quoted,
    shown, unclosed, word,
};
use crate::{Diagnostic, LongList, Spanned, Text, nearest, numbers};

/// The most bad values that are reported for one list.
const FAULTS_PER_LIST: usize = 5;

impl<'a> Reader<'a> {
    /// Reads parameters up to the next directive. Reports and omits unreadable ones.
    pub(crate) fn params(&mut self, input: Input<'a>) -> (Input<'a>, Vec<Param>) {
        let mut params = Vec::new();
        let mut input = input;
        loop {
            let next = blank(input).map_or(input, |(next, ())| next);
            let next = self.after_stray(next);
            if self.exhausts(PARAM_BYTES, next) {
                return (&input[input.len()..], params);
            }
            let declaration = match next.first() {
                Some(b'"') => self.closed_declaration(next),
                _ => match self.unopened_declaration(next) {
                    Some(read) => Ok(read),
                    None => return (input, params),
                },
            };
            match declaration.and_then(|(rest, declaration)| self.param(rest, declaration)) {
                Ok((rest, param)) => {
                    params.extend(param);
                    input = rest;
                }
                Err(nom::Err::Error(fault) | nom::Err::Failure(fault)) => {
                    return (self.recover(fault), params);
                }
                Err(nom::Err::Incomplete(_)) => return (input, params),
            }
        }
    }

    /// Reads the values after a declaration. `None` for an unreadable parameter, which it reports.
    fn param(&mut self, input: Input<'a>, declaration: Text) -> Parsing<'a, Option<Param>> {
        let faulty_before = std::mem::replace(&mut self.faulty, false);
        let read = self.readable_param(input, declaration);
        let faulty = std::mem::replace(&mut self.faulty, true);
        self.faulty = faulty || faulty_before;
        read.map(|(rest, param)| (rest, param.filter(|_| !faulty)))
    }

    /// Adds help to an error: a string in the place of a material's number or color probably names a texture.
    fn advise_texture(&mut self, ty: ParamType, name: &str) {
        if !matches!(ty, ParamType::Float | ParamType::Rgb | ParamType::Xyz) {
            return;
        }
        let is_of_material = word(self.statement)
            .is_ok_and(|(_, keyword)| matches!(keyword, b"Material" | b"MakeNamedMaterial" | b"Texture"));
        let text = self.text;
        let is_string = |error: &&mut Diagnostic| text.get(error.span().start as usize) == Some(&b'"');
        let last = self.parsed.diagnostics.last_mut().filter(|error| error.help.is_none());
        if let Some(error) = last.filter(is_string).filter(|_| is_of_material) {
            error.help = Some(format!("to use a texture, write \"texture {name}\""));
        }
    }

    fn readable_param(&mut self, input: Input<'a>, declaration: Text) -> Parsing<'a, Option<Param>> {
        let (start, ()) = blank(input)?;
        let declared = self.declaration(&declaration, start);
        let list = start.first() == Some(&b'[');
        self.fraction = false;
        self.commas = Commas::default();
        let mut values = self.empty(declared.as_ref().map(|(ty, _)| *ty), &start[usize::from(list)..]);
        if !list && self.lacks_value(start, &values) {
            if declared.is_some() {
                let at = declaration.span;
                let error = Diagnostic::error(at, format!("\"{}\" has no value", declaration.value));
                let hex = hex_color(input).filter(|_| matches!(values, Values::Triples(_)));
                self.parsed.diagnostics.push(match hex {
                    Some((code, color)) => error
                        .help(format!("`#` starts a comment; write red, green and blue from 0 to 1: {color}"))
                        .fix(self.span(code), color),
                    None => error.help("write the value after the declaration"),
                });
                self.faulty = true;
            }
            return Ok((input, None));
        }
        // A string without a type declares nothing and has no value: the next string is the next declaration.
        let next = quoted(start).ok().filter(|_| declared.is_none());
        if next.is_some_and(|(_, text)| text.split(' ').next().and_then(ParamType::from_spelling).is_some()) {
            return Ok((input, None));
        }
        if list && let (rest, true) = self.nested_list(start)? {
            return Ok((rest, None));
        }
        if let Some(rest) = self.list_in_others(start) {
            return Ok((rest, None));
        }
        let at = self.offset(start);
        let known = declared.as_ref().filter(|_| list).and_then(|(ty, _)| (self.known)(*ty, at));
        let (rest, count) = match known.and_then(|length| start.get(length..)) {
            Some(rest) => (rest, 0),
            None if list => {
                let read = self.list(&start[1..], &start[..1], &mut values)?;
                self.has_decimal_commas(&values);
                read
            }
            None => self.single(start, &mut values)?,
        };
        if let Some((ty, name)) = declared.as_ref().filter(|_| self.faulty) {
            self.advise_texture(*ty, name);
        }
        let span = self.between(start, rest);
        let rest = if rest.first() == Some(&b',') { self.separator(rest)?.0 } else { rest };
        let Some((ty, name)) = declared else { return Ok((rest, None)) };
        if !self.faulty && count % ty.arity() != 0 {
            let message = miscounted(ty, &shown(name.as_bytes()), count);
            self.parsed.diagnostics.push(completed(Diagnostic::error(span, message), ty, count, &values));
            self.faulty = true;
        }
        let are_numbers = !matches!(values, Values::Strings(_) | Values::Bools(_));
        let is_long = (span.end - span.start) as usize >= LongList::BYTES;
        if list && is_long && are_numbers && !self.faulty && !self.fraction && self.commas.first.is_none() {
            self.parsed.lists.push(LongList { ty, span });
        }
        let name = Spanned { value: name, span: declaration.span };
        let is_read = known.is_none();
        Ok((rest, Some(Param { ty, name, values: Spanned { value: values, span }, is_read })))
    }

    /// The values of a text that is a list without mistakes.
    pub(crate) fn values(&mut self, ty: ParamType) -> Values {
        let text = self.text;
        let mut values = self.empty(Some(ty), &[]);
        if let Some((open, rest)) = text.split_at_checked(1) {
            let _ = self.list(rest, open, &mut values);
        }
        values
    }

    /// True if the next declaration or directive follows instead of a value.
    fn lacks_value(&self, input: Input<'a>, values: &Values) -> bool {
        let at = word(input).map_or(&input[..input.len().min(1)], |(_, word)| word);
        ends_list(at) || !matches!(values, Values::Strings(_)) && is_declaration(input)
    }

    /// Reads one value without brackets.
    fn single(&mut self, input: Input<'a>, values: &mut Values) -> Parsing<'a, usize> {
        let rest = match self.value(input, values, 0) {
            Ok((rest, ())) => rest,
            // A word that is not a keyword is meant as the value.
            Err(nom::Err::Error(fault) | nom::Err::Failure(fault)) if !open_string(input) => {
                let (word, _) = found(input);
                let skipped = word.len().max(fault.at.len());
                self.report(fault);
                return Ok((self.after_values(&input[skipped..])?.0, 0));
            }
            Err(error) => return Err(error),
        };
        let (end, more) = self.more_numbers(rest)?;
        if let (after, true) = self.after_values(end)? {
            let fault = SyntaxError::new(&input[..input.len() - end.len()], "unexpected value before `[`");
            self.report(fault.help("delete it"));
            return Ok((after, 1 + more));
        }
        if let (rest, true) = self.unopened_list(input, end)? {
            return Ok((rest, 1 + more));
        }
        if !self.has_decimal_commas(values) && more > 0 {
            let all = &input[..input.len() - end.len()];
            let fault = SyntaxError::new(all, "several values without brackets");
            let text = String::from_utf8_lossy(all);
            self.report(fault.help("put them in brackets").replace_with(format!("[{text}]")));
        }
        Ok((end, 1 + more))
    }

    /// Splits a declaration such as `"float radius"`, before these values. Reports other strings.
    fn declaration(&mut self, declaration: &Text, values: Input<'a>) -> Option<(ParamType, String)> {
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
                    let slips =
                        [("int", "integer"), ("boolean", "bool"), ("str", "string"), ("colour", "color")];
                    let slip = slips.iter().find(|(slip, _)| *slip == ty).map(|(_, known)| *known);
                    let spellings = ParamType::SPELLINGS.map(|(spelling, _)| spelling);
                    match slip.or_else(|| nearest(ty, spellings)) {
                        Some(known) => error
                            .help(format!("did you mean `{known}`?"))
                            .fix(at, format!("\"{known} {name}\"")),
                        None => {
                            error.help(format!("write a type and the name, as in {}", example(name, values)))
                        }
                    }
                }
            },
            (Some(only), None) => {
                let error = Diagnostic::error(at, format!("\"{only}\" does not declare a parameter"));
                let after = word(self.statement).and_then(|(rest, _)| blank(rest));
                let is_named = self.statement.starts_with(b"MakeNamed");
                if is_named && after.is_ok_and(|(first, ())| is_declaration(first)) {
                    error.help("write the name first: MakeNamedMaterial \"red\" \"string type\" \"matte\"")
                } else if is_named {
                    // The type of a named material or medium is a parameter.
                    let declaration = match only {
                        "type" => "\"string type\"".to_owned(),
                        _ => format!("\"string type\" \"{only}\""),
                    };
                    error.help(format!("write the type as {declaration}")).fix(at, declaration)
                } else {
                    error.help(format!(
                        "write the type and the name in one string, as in {}",
                        example(only, values)
                    ))
                }
            }
            _ => Diagnostic::error(at, "an empty parameter declaration")
                .help("write the type and the name in one string, as in \"float radius\""),
        };
        self.parsed.diagnostics.push(error);
        None
    }

    /// An empty list for the values of a type. Without a type, the first value decides.
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

    /// Reads the values up to the closing bracket, and counts them.
    fn list(&mut self, input: Input<'a>, open: Input<'a>, values: &mut Values) -> Parsing<'a, usize> {
        let mut input = input;
        let (mut count, mut faults) = (0, 0);
        loop {
            let quick;
            (input, quick) = numbers::plain(input, values, count);
            count += quick;
            (input, _) = self.separator(input)?;
            match input.first() {
                Some(b']') => return Ok((&input[1..], count)),
                None => return unclosed(open, input).fail(),
                _ => {}
            }
            match self.value(input, values, count) {
                Ok((rest, ())) => input = rest,
                Err(nom::Err::Error(fault) | nom::Err::Failure(fault)) if open_string(input) => {
                    return fault.fail();
                }
                Err(nom::Err::Error(fault) | nom::Err::Failure(fault)) => {
                    let word = fault.at;
                    // Before a directive or declaration, the closing bracket is missing.
                    if ends_list(word) || is_declaration(word) {
                        return unclosed(open, input).fail();
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

    /// Reads one value and appends it. `index` counts numbers, not points.
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
                if input.first() == Some(&b'"') {
                    let (rest, text) = self.closed_string(input)?;
                    if self.exhausts(STRING_BYTES, input) {
                        return Ok((&input[input.len()..], ()));
                    }
                    list.push(text);
                    return Ok((rest, ()));
                }
                if let Some(fault) = unopened(input) {
                    return fault.fail();
                }
                let (at, found) = found(input);
                let fault = SyntaxError::new(at, format!("expected a quoted string, found {found}"));
                let is_plain = |byte: &u8| byte.is_ascii_graphic() && !b"[]\"#\\".contains(byte);
                if at.is_empty() || !at.iter().all(is_plain) {
                    return fault.fail();
                }
                let fault = fault.help("write strings in double quotes");
                // A number is probably not meant as a name.
                let is_number = number(at).is_ok();
                if is_number { fault } else { fault.replace_with(format!("\"{}\"", shown(at))) }.fail()
            }
        }
    }

    fn integer(&mut self, input: Input<'a>) -> Parsing<'a, i32> {
        let (rest, value) = number(input)?;
        let at = &input[..input.len() - rest.len()];
        if value < f64::from(i32::MIN) || value > f64::from(i32::MAX) {
            return SyntaxError::new(at, format!("{} is out of range for an integer", shown(at)))
                .help("the range is -2147483648 to 2147483647")
                .fail();
        }
        if value.fract() != 0.0 && !self.fraction {
            self.fraction = true;
            let warning = Diagnostic::warning(self.span(at), format!("{} is not an integer", shown(at)))
                .help(format!("pbrt-v3 drops the fraction: {}", value.trunc()));
            self.parsed.diagnostics.push(warning);
        }
        Ok((rest, value as i32))
    }
}

/// The declaration of a parameter whose type is missing or unknown, by its values. `name` can be the type itself.
fn example(name: &str, values: Input) -> String {
    let first = values.strip_prefix(b"[").unwrap_or(values).trim_ascii_start();
    let text = quoted(first).ok().map(|(_, text)| text);
    if ParamType::from_spelling(name).is_some() {
        let own = text.filter(|text| !text.is_empty() && !text.contains(' '));
        return format!("\"{name} {}\"", own.map_or("radius".into(), |text| shown(text.as_bytes())));
    }
    let ty = if text.is_some() { "string" } else { "float" };
    format!("\"{ty} {}\"", shown(name.as_bytes()))
}

/// The message about a list that does not divide into values.
fn miscounted(ty: ParamType, name: &str, count: usize) -> String {
    let arity = ty.arity();
    let (what, parts) = match ty {
        ParamType::Rgb => ("color", "red, green, blue"),
        ParamType::Xyz => ("color", "X, Y, Z"),
        ParamType::Blackbody => ("pair", "kelvin, scale"),
        ParamType::Normal => ("normal", "x, y, z"),
        ParamType::Point2 => ("point", "x, y"),
        ParamType::Vector2 => ("vector", "x, y"),
        ParamType::Vector3 => ("vector", "x, y, z"),
        _ => ("point", "x, y, z"),
    };
    match count % arity {
        rest if count > arity && what != "color" => {
            let numbers = if rest == 1 { "number" } else { "numbers" };
            format!("the last {what} of {name} has {rest} {numbers} instead of {arity} ({count} in total)")
        }
        _ => format!("{name} needs {arity} numbers ({parts}), found {count}"),
    }
}

/// A color as on web pages, such as `#ffee00`, after a declaration: its text, and its linear red, green and blue.
fn hex_color(input: Input) -> Option<(Input, String)> {
    let code = input.trim_ascii_start();
    let code = &code[..code.iter().position(|byte| is_delimiter(*byte)).unwrap_or(code.len())];
    let digits = code.strip_prefix(b"#").filter(|digits| digits.len() == 6)?;
    let linear = |pair: &[u8]| {
        let value = u8::from_str_radix(str::from_utf8(pair).ok()?, 16).ok()?;
        let value = f64::from(value) / 255.0;
        let linear = if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) };
        Some(((linear * 1000.0).round() / 1000.0).to_string())
    };
    let linear: Option<Vec<String>> = digits.chunks(2).map(linear).collect();
    Some((code, format!("[{}]", linear?.join(" "))))
}

/// Adds help to the error of a value with too few or too many numbers.
fn completed(error: Diagnostic, ty: ParamType, count: usize, values: &Values) -> Diagnostic {
    let at = error.span();
    // Numbers outside this range print with many digits.
    let is_plain = |number: f64| number == 0.0 || (1e-6..1e9).contains(&number.abs());
    match (ty, count, values) {
        (ParamType::Rgb, 1, Values::Triples(triples)) if is_plain(triples[0][0]) => {
            let gray = triples[0][0];
            let three = format!("[{gray} {gray} {gray}]");
            error.help(format!("write a gray as three equal numbers: {three}")).fix(at, three)
        }
        (ParamType::Blackbody, 1, Values::Pairs(pairs)) if is_plain(pairs[0][0]) => {
            let pair = format!("[{} 1]", pairs[0][0]);
            error.help(format!("write the temperature in kelvin and a factor: {pair}")).fix(at, pair)
        }
        (ParamType::Blackbody, ..) => error.help("write pairs of a temperature in kelvin and a factor"),
        _ => error,
    }
}

/// True if the input starts with an unreadable string. The meaning of the text after it is unknown.
fn open_string(input: Input) -> bool {
    input.first() == Some(&b'"') && quoted(input).is_err()
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
            _ => {
                let text = shown(text.as_bytes());
                let fault = SyntaxError::new(at, format!("a bool is \"true\" or \"false\", not \"{text}\""));
                match text.to_ascii_lowercase() {
                    small if small == "true" || small == "false" => {
                        fault.help("write it in lower case").replace_with(format!("\"{small}\""))
                    }
                    _ => fault,
                }
                .fail()
            }
        };
    }
    let (at, found) = found(input);
    let fault = SyntaxError::new(at, format!("expected \"true\" or \"false\" in quotes, found {found}"));
    let meant = match at {
        b"true" | b"1" => "\"true\"",
        b"false" | b"0" => "\"false\"",
        _ => return fault.fail(),
    };
    fault.help("write a bool as a word in quotes").replace_with(meant).fail()
}
