//! Foreign text, such as names of files and layers, without characters that would act on a terminal.

/// Text of one line with each character that acts on a terminal replaced by one that is seen in its place. Columns stay.
pub fn visible(text: &str) -> String {
    text.chars().map(|c| if is_active(c) { stand_in(c) } else { c }).collect()
}

/// Text of several lines, with the same replaced in each.
pub fn visible_lines(text: &str) -> String {
    text.chars().map(|c| if is_active(c) && c != '\n' { stand_in(c) } else { c }).collect()
}

/// JSON text with the same characters escaped: JSON itself leaves those beyond C0 as they are.
pub fn escaped(json: &str) -> String {
    let mut out = String::with_capacity(json.len());
    for c in json.chars() {
        match is_active(c) && c != '\n' {
            true => out += &format!("\\u{:04x}", u32::from(c)),
            false => out.push(c),
        }
    }
    out
}

/// Whether a character moves the cursor, changes the direction of text, or begins a command to a terminal.
pub fn is_active(c: char) -> bool {
    // Marks, embeddings and isolates of bidirectional text; separators of lines and paragraphs.
    let is_format =
        matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    c.is_control() || is_format
}

/// The picture of a control character of ASCII; of others the replacement character.
pub fn stand_in(c: char) -> char {
    let picture = match u32::from(c) {
        code @ 0..0x20 => char::from_u32(0x2400 + code),
        0x7f => Some('\u{2421}'),
        _ => None,
    };
    picture.unwrap_or(char::REPLACEMENT_CHARACTER)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_character_has_one_in_its_place() {
        let text = "a\u{1b}[2J\r\n\t\u{7f}\u{9b}\u{202e}\u{2066}\u{2028}\u{200f}\u{61c}é漢";
        assert_eq!(visible(text), "a␛[2J␍␊␉␡\u{fffd}\u{fffd}\u{fffd}\u{fffd}\u{fffd}\u{fffd}é漢");
        assert_eq!(visible(text).chars().count(), text.chars().count());
        assert_eq!(visible_lines("a\nb\r"), "a\nb␍");
    }

    #[test]
    fn json_stays_the_same_value() {
        let text = "a\u{1b}\u{7f}\u{9b}\u{202e}\n\u{2029}é";
        let json = escaped(&serde_json::to_string(text).unwrap());
        assert!(!json.contains(is_active), "{json}");
        assert_eq!(serde_json::from_str::<String>(&json).unwrap(), text);
    }
}
