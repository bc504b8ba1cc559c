//! Prints help, and what is wrong with a command line.

use std::io;
use std::path::Path;
use std::process::ExitCode;

use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Arg, Command, CommandFactory, Error, Parser};
use lookat_scene::syntax::nearest;

use crate::args::Arguments;
use crate::readable::visible;

/// Prints help, or the error of the command line.
pub fn explain(error: Error) -> ExitCode {
    let typed = typed();
    let error = if error.use_stderr() { with_tips(error, &typed) } else { error };
    ExitCode::from(match error.print() {
        // The help could not be written. A closed pipe is fine, because nobody reads it.
        Err(trouble) if trouble.kind() != io::ErrorKind::BrokenPipe => crate::lost(),
        _ if error.use_stderr() => crate::TROUBLE,
        _ => 0,
    })
}

/// A tip about an option of `render` that is typed with one dash, to end a message.
pub fn tip_for_render() -> String {
    let root = Arguments::command();
    let tip = root.find_subcommand("render").and_then(|render| one_dash(&typed()[1..], render));
    tip.map_or(String::new(), |tip| format!("; tip: {tip}"))
}

fn typed() -> Vec<String> {
    std::env::args_os().map(|typed| visible(&typed.to_string_lossy())).collect()
}

/// The usage error in printable text, with lookat's own tips instead of the parser's tips.
pub fn with_tips(error: Error, typed: &[String]) -> Error {
    let mut error = Arguments::try_parse_from(typed).err().unwrap_or(error);
    let mut root = Arguments::command();
    root.build();
    let name = typed.get(1).map_or("", String::as_str);
    let command = root.find_subcommand(name).unwrap_or(&root);
    let tip = match error.kind() {
        ErrorKind::InvalidSubcommand if name.ends_with(".pbrt") => {
            Some(format!("to render the scene, write 'lookat render {}'", typed[1..].join(" ")))
        }
        ErrorKind::InvalidSubcommand if name == "bench" => {
            Some("in the source of lookat, run 'cargo run --release -p lookat-lab -- bench'".into())
        }
        ErrorKind::UnknownArgument => {
            // The parser suggests giving an unknown option as a value, which the user hardly ever means.
            error.remove(ContextKind::Suggested);
            error.insert(ContextKind::Usage, ContextValue::StyledStr(command.clone().render_usage()));
            let unknown = match error.get(ContextKind::InvalidArg) {
                Some(ContextValue::String(unknown)) => unknown.clone(),
                _ => String::new(),
            };
            tip_for(&unknown, &typed[1..], command, &root)
        }
        _ => None,
    };
    if let Some(tip) = tip {
        error.remove(ContextKind::SuggestedArg);
        error.remove(ContextKind::SuggestedSubcommand);
        error.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![tip.into()]));
    }
    error
}

/// Options of other renderers and their names here.
const SYNONYMS: [(&str, &str); 12] = [
    ("samples", "--spp"),
    ("samples-per-pixel", "--spp"),
    ("pixelsamples", "--spp"),
    ("width", "--resolution"),
    ("height", "--resolution"),
    ("size", "--resolution"),
    ("res", "--resolution"),
    ("jobs", "--threads"),
    ("cores", "--threads"),
    ("file", "--output"),
    ("memory", "--max-memory"),
    ("tolerance", "--max"),
];

/// A tip for an option or a word that the command does not know.
fn tip_for(unknown: &str, typed: &[String], command: &Command, root: &Command) -> Option<String> {
    // The parser reports `-spp 4` as `-s`. It reads `-out a.exr` as `-o ut`, and reports the word after it.
    if !unknown.starts_with("--")
        && let Some(tip) = one_dash(typed, command)
    {
        return Some(tip);
    }
    let is_reported = |word: &String| {
        if unknown.starts_with("--") {
            word.split('=').next() == Some(unknown)
        } else {
            word.starts_with(unknown)
        }
    };
    let at = typed.iter().position(is_reported)?;
    let word = typed[at].as_str();
    let before = at.checked_sub(1).map_or("", |before| typed[before].as_str());
    if option(command, before).is_some_and(|option| option.get_action().takes_values()) {
        return Some(format!("to give '{word}' as the value of '{before}', write '{before}={word}'"));
    }
    if word.starts_with('-') && Path::new(word).exists() {
        return Some(format!("a file name that begins with a dash is written './{word}'"));
    }
    let synonym = SYNONYMS.iter().find(|(other, _)| unknown.strip_prefix("--") == Some(other));
    if let Some((_, own)) = synonym.filter(|(_, own)| option(command, own).is_some()) {
        return Some(format!("lookat calls this '{own}'"));
    }
    let others = root.get_subcommands().filter(|other| option(other, unknown).is_some());
    let others: Vec<String> = others.map(|other| format!("'lookat {}'", other.get_name())).collect();
    (!others.is_empty()).then(|| format!("'{unknown}' is an option of {}", others.join(", ")))
}

fn one_dash(typed: &[String], command: &Command) -> Option<String> {
    let long = typed.iter().find_map(|word| long_of_one_dash(word, command))?;
    Some(format!("options of several letters begin with two dashes: '--{long}'"))
}

/// The option with this spelling, `--long` or `-s`.
fn option<'c>(command: &'c Command, typed: &str) -> Option<&'c Arg> {
    let is = |arg: &&Arg| match typed.strip_prefix("--") {
        Some(long) => longs(arg).contains(&long),
        None => {
            arg.get_short().is_some_and(|short| typed.strip_prefix('-') == Some(short.to_string().as_str()))
        }
    };
    command.get_arguments().find(is)
}

fn longs(arg: &Arg) -> Vec<&str> {
    arg.get_long_and_visible_aliases().unwrap_or_default()
}

/// The long option that the user means by a word such as `-spp`.
fn long_of_one_dash<'c>(word: &str, command: &'c Command) -> Option<&'c str> {
    let name = word.strip_prefix('-').filter(|name| !name.starts_with('-') && name.len() > 2)?;
    let all: Vec<&str> = command.get_arguments().flat_map(longs).collect();
    let extended = all.iter().copied().find(|long| long.starts_with(name));
    extended.or_else(|| nearest(name, all))
}
