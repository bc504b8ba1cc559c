//! Text for people: numbers, and foreign text such as file names, for terminals, JSON and shells.

use std::ffi::OsStr;
use std::fmt::Write;
use std::path::Path;

/// Replaces each character that controls a terminal, including line ends, by one visible character. Columns stay the
/// same.
pub fn visible(text: &str) -> String {
    text.chars().map(|c| if is_active(c) { stand_in(c) } else { c }).collect()
}

/// Like [`visible`], but keeps line ends.
pub fn visible_lines(text: &str) -> String {
    text.chars().map(|c| if is_active(c) && c != '\n' { stand_in(c) } else { c }).collect()
}

/// Escapes the same characters in JSON text, except line ends. JSON itself requires an escape only below U+0020.
pub fn escaped(json: &str) -> String {
    let mut out = String::with_capacity(json.len());
    for c in json.chars() {
        if is_active(c) && c != '\n' {
            for unit in c.encode_utf16(&mut [0; 2]) {
                out += &format!("\\u{unit:04x}");
            }
        } else {
            out.push(c)
        }
    }
    out
}

/// True for a character that moves the cursor, changes the direction of text, begins a terminal command, or is
/// invisible.
pub fn is_active(c: char) -> bool {
    // Marks, embeddings and isolates of bidirectional text; separators of lines and paragraphs.
    let is_format =
        matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    // Soft hyphen, zero-width space, word joiner, byte-order mark, tags. Joiners are allowed: emoji and some scripts
    // use them.
    let is_hidden =
        matches!(c, '\u{ad}' | '\u{200b}' | '\u{2060}'..='\u{2064}' | '\u{feff}' | '\u{e0000}'..='\u{e007f}');
    c.is_control() || is_format || is_hidden
}

/// The visible picture of an ASCII control character. The replacement character for all other characters.
pub fn stand_in(c: char) -> char {
    let picture = match u32::from(c) {
        code @ 0..0x20 => char::from_u32(0x2400 + code),
        0x7f => Some('\u{2421}'),
        _ => None,
    };
    picture.unwrap_or(char::REPLACEMENT_CHARACTER)
}

/// Goes to the working folder and runs lookat with the same arguments.
pub fn repeated_command() -> String {
    let folder = std::env::current_dir().unwrap_or_default();
    let mut command = format!("cd {} && lookat", quoted(folder.as_os_str()));
    for argument in std::env::args_os().skip(1) {
        let _ = write!(command, " {}", quoted(&argument));
    }
    command
}

/// An argument as one word of a POSIX shell.
pub fn quoted(argument: &OsStr) -> String {
    // A shell loses line ends at the end of what a command prints.
    let is_plain = |text: &&str| !text.trim_end_matches('\n').contains(is_active);
    let text = argument.to_str().filter(is_plain);
    let text = text.and_then(|text| shlex::try_quote(text).ok());
    text.map_or_else(|| printed(argument.as_encoded_bytes()), |text| text.into_owned())
}

/// A file as one word of a POSIX shell, which no program takes for an option.
pub fn quoted_file(file: &Path) -> String {
    if file.as_os_str().as_encoded_bytes().starts_with(b"-") {
        quoted(Path::new(".").join(file).as_os_str())
    } else {
        quoted(file.as_os_str())
    }
}

/// A word that is not UTF-8, which a web page cannot hold, or not visible, as its bytes in octal.
fn printed(bytes: &[u8]) -> String {
    let octal: String = bytes.iter().map(|byte| format!("\\{byte:03o}")).collect();
    format!("\"$(printf '{octal}')\"")
}

/// A share in percent, with so many decimals at most. Only 0 and 1 are shown as 0 % and 100 %.
pub fn percent(share: f64, decimals: usize) -> String {
    let units = 10_f64.powi(decimals as i32);
    let (percent, least) = (100.0 * share, 1.0 / units);
    if percent > 0.0 && percent < least {
        format!("under {least} %")
    } else if percent > 100.0 - least && percent < 100.0 {
        format!("over {} %", 100.0 - least)
    } else {
        format!("{} %", (units * percent).round() / units)
    }
}

/// A number with commas and a noun.
pub fn count(number: u64, noun: &str) -> String {
    plural(number, noun, &format!("{noun}s"))
}

/// A number with commas and a noun in one of two forms.
pub fn plural(number: u64, one: &str, many: &str) -> String {
    format!("{} {}", grouped(number), if number == 1 { one } else { many })
}

/// A number with commas.
pub fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let groups: Vec<&str> =
        digits.as_bytes().rchunks(3).rev().filter_map(|group| str::from_utf8(group).ok()).collect();
    groups.join(",")
}

#[cfg(test)]
mod tests {
    use std::process::Command;

    use super::*;

    #[test]
    fn each_active_character_becomes_one_visible_character() {
        let text =
            "a\u{1b}[2J\r\n\t\u{7f}\u{9b}\u{202e}\u{2066}\u{2028}\u{200f}\u{61c}\u{200b}\u{e0041}é漢\u{200d}";
        assert_eq!(
            visible(text),
            "a␛[2J␍␊␉␡\u{fffd}\u{fffd}\u{fffd}\u{fffd}\u{fffd}\u{fffd}\u{fffd}\u{fffd}é漢\u{200d}"
        );
        assert_eq!(visible(text).chars().count(), text.chars().count());
        assert_eq!(visible_lines("a\nb\r"), "a\nb␍");
    }

    #[test]
    fn json_stays_the_same_value() {
        let text = "a\u{1b}\u{7f}\u{9b}\u{202e}\n\u{2029}\u{e0041}é";
        let json = escaped(&serde_json::to_string(text).unwrap());
        assert!(!json.contains(is_active), "{json}");
        assert_eq!(serde_json::from_str::<String>(&json).unwrap(), text);
    }

    /// A shell makes the same argument of it.
    #[cfg(unix)]
    #[test]
    fn a_shell_reads_the_same_word() {
        use std::os::unix::ffi::OsStrExt;

        let words = [
            &b"plain"[..],
            b"",
            b"a b",
            b"it's",
            b"$HOME `x` \"y\" \\ \n!*~",
            b"caf\xe9 %s",
            b"a\tb",
            b"a\n",
        ];
        for word in words {
            let quoted = quoted(OsStr::from_bytes(word));
            let script = format!("printf %s {quoted}");
            let output = Command::new("sh").args(["-c", &script]).output().unwrap();
            assert_eq!(output.stdout, word, "{quoted}");
        }
        assert_eq!(quoted(OsStr::new("a\tb")), r#""$(printf '\141\011\142')""#);
        assert_eq!(["-a b", "a-b"].map(|name| quoted_file(Path::new(name))), ["'./-a b'", "a-b"]);
    }

    #[test]
    fn large_numbers_have_commas() {
        assert_eq!([1, 999, 1000, 1_234_567].map(grouped), ["1", "999", "1,000", "1,234,567"]);
    }

    #[test]
    fn shares_are_rounded_but_never_to_all_or_nothing() {
        let shares = [0.0, 1e-6, 0.003, 0.12345, 0.5, 0.999_99, 1.0].map(|share| percent(share, 1));
        assert_eq!(shares, ["0 %", "under 0.1 %", "0.3 %", "12.3 %", "50 %", "over 99.9 %", "100 %"]);
        assert_eq!([0.5, 0.98765, 1e-5].map(|share| percent(share, 2)), ["50 %", "98.77 %", "under 0.01 %"]);
    }
}
