//! Commas between numbers, and decimal commas.

use crate::Diagnostic;
use crate::grammar::Reader;
use crate::param::Values;
use crate::token::{Input, Parsing, is_delimiter, separator, shown, with_point};

impl<'a> Reader<'a> {
    /// Skips white space and commas between values.
    pub(crate) fn separator(&mut self, input: Input<'a>) -> Parsing<'a, ()> {
        let (rest, has_comma) = separator(input)?;
        // A word with many commas is read once: it separates values.
        if has_comma && !self.commas.separates {
            let at = self.offset(input) + input.iter().position(|byte| *byte == b',').unwrap_or(0);
            self.commas.first.get_or_insert(&self.text[at..=at]);
            let word = word_around(self.text, at);
            match with_point(word) {
                Some(_) => drop(self.commas.decimal.get_or_insert(word)),
                None => {
                    self.commas.separates = true;
                    self.warn_of_commas();
                }
            }
        }
        Ok((rest, ()))
    }

    /// Reports the decimal commas since the last call, and at the end of the file that commas separate numbers.
    pub(crate) fn report_commas(&mut self, is_at_end: bool) {
        if let Some((first, others)) = std::mem::take(&mut self.decimal_commas).split_first() {
            // All have the words of the first error of the file, which makes them one problem.
            let error = self.decimal_comma.clone().map(|mut error| {
                error.labels[0].span = *first;
                error.places = others.to_vec();
                error
            });
            self.diagnostics.extend(error);
        }
        let comma = self.comma.filter(|_| is_at_end);
        self.diagnostics.extend(comma.map(|at| {
            Diagnostic::warning(at, "commas separate these numbers")
                .help("separate numbers by spaces, and use a decimal point; pbrt-v3 ignores the comma and the rest of the word")
        }));
    }

    fn warn_of_commas(&mut self) {
        self.comma = self.comma.or(self.commas.first.map(|comma| self.span(comma)));
    }

    /// Reports the decimal commas of the current list, after its values are read. True if there are any.
    pub(crate) fn has_decimal_commas(&mut self, values: &Values) -> bool {
        let decimal = self.commas.decimal.filter(|_| !self.commas.separates);
        let Some((word, meant)) = decimal.and_then(|word| Some((word, with_point(word)?))) else {
            return false;
        };
        if matches!(values, Values::Integers(_)) {
            self.warn_of_commas();
            return false;
        }
        self.faulty = true;
        let at = self.span(word);
        self.decimal_commas.push(at);
        if self.decimal_comma.is_some() {
            return true;
        }
        let (word, one) = (shown(word), shown(&meant));
        let two = word.replace(',', " ");
        let error = Diagnostic::error(at, format!("`{word}` may be one number or two"))
            .help(format!("write one number with a point: {one}; write two with a space: {}", two.trim()));
        // Points of a plane are pairs in other formats, such as `0,1 1,1` in SVG.
        let are_pairs = matches!(values, Values::Pairs(_));
        self.decimal_comma = Some(if are_pairs { error } else { error.fix(at, one) });
        true
    }
}

/// The word around a byte.
fn word_around(text: Input, at: usize) -> Input {
    let is_outside = |byte: &u8| is_delimiter(*byte);
    let start = text[..at].iter().rposition(is_outside).map_or(0, |before| before + 1);
    let end = text[at..].iter().position(is_outside).map_or(text.len(), |length| at + length);
    &text[start..end]
}
