//! The program `lookat`. See its `--help`, and README.md.

#[macro_use]
mod failure;

mod args;
mod chart;
mod check;
mod compare;
mod convert;
mod explain;
mod farm;
mod inspect;
mod interrupt;
mod light;
mod live;
mod merge;
mod output;
mod part;
mod readable;
mod render;
mod report;
mod resume;
mod scene_result;
mod source;
mod stability;
mod standard_error;
mod usage;
mod verify;
mod view;
mod writer;

use std::io::{ErrorKind, IsTerminal, Write};
use std::ops::ControlFlow;
use std::process::ExitCode;
use std::sync::mpsc;

use clap::Parser as _;

use crate::failure::{Failure, exit_code};
use crate::readable::{escaped, visible, visible_lines};
use crate::writer::{Writer, write_parts};

/// The exit status for wrong usage, and for errors outside scene files.
const TROUBLE: u8 = 2;

fn main() -> ExitCode {
    interrupt::survive_abort();
    let arguments = match args::Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(error) => return usage::explain(error),
    };
    // The first allocation of a thread takes all addresses that are left, up to 128 MB. This keeps some of them.
    let mut kept = Vec::<u8>::new();
    let _ = kept.try_reserve_exact(KEPT_BYTES);
    interrupt::watch();
    drop(std::hint::black_box(kept));
    start_threads(&arguments.command);
    let status = match arguments.command {
        args::Command::Render(arguments) => render::render(&arguments, None),
        args::Command::Resume(arguments) => resume::resume(&arguments),
        args::Command::View(arguments) => view::view(&arguments),
        args::Command::Check(arguments) => check::check(&arguments),
        args::Command::Compare(arguments) => compare::compare(&arguments),
        args::Command::Merge(arguments) => merge::merge(&arguments),
        args::Command::Farm(arguments) => farm::farm(&arguments),
        args::Command::Convert(arguments) => convert::convert(&arguments),
        args::Command::Verify(arguments) => verify::verify(&arguments),
        args::Command::Chart(arguments) => chart::chart(&arguments),
        args::Command::Stability(arguments) => stability::stability(&arguments),
        args::Command::Inspect(arguments) => inspect::inspect(&arguments),
        args::Command::Explain(arguments) => explain::explain(&arguments),
    };
    wait_for_messages();
    status
}

/// The bytes of addresses that a limit leaves at least for what a command does. Above 32 MB, because glibc keeps as much memory as the
/// largest smaller piece that was given back (`M_MMAP_THRESHOLD`).
const KEPT_BYTES: usize = 40 << 20;

/// Starts the threads of a command. Warns if the system does not allow all of them.
fn start_threads(command: &args::Command) {
    let requested = command.threads().map(usize::from);
    let wanted =
        requested.or_else(|| std::thread::available_parallelism().ok().map(usize::from)).unwrap_or(1);
    let started = lookat_render::start_threads(wanted);
    if started < wanted {
        let lower = if requested.is_some() { "lower --threads, or " } else { "" };
        say(&format!(
            "warning: {started} of {wanted} threads could be started; {lower}raise ulimit -v or ulimit -u"
        ));
    }
}

/// Waits until all messages are written; after a signal, not on a pipe that nobody reads.
fn wait_for_messages() {
    standard_error::wait(|| interrupt::flow().is_break());
}

/// Prints one line of JSON to standard output.
fn print_json(value: &impl serde::Serialize) -> Result<(), Failure> {
    print(&(escaped(&serde_json::to_string(value).unwrap_or_default()) + "\n"))
}

/// Prints text to standard output. Ends the program if the reader, such as `head`, has closed the pipe. If standard error is detached,
/// gives up on a terminal that does not read, and after a signal also on a pipe.
fn print(text: &str) -> Result<(), Failure> {
    let text = visible_lines(text);
    if !standard_error::is_detached() {
        return write_out(&text, &|| ());
    }
    wait_for_messages();
    let (tell, told) = mpsc::channel();
    let writer = Writer::new(move |text: String, progress| {
        let _ = tell.send(write_out(&text, progress));
        ControlFlow::Break(())
    });
    let Ok(writer) = writer else { return write_out(&text, &|| ()) };
    writer.put(|queue| queue.push_back(text));
    writer.wait(|| std::io::stdout().is_terminal() || interrupt::flow().is_break());
    told.try_recv().unwrap_or(Err(Failure::Unwritten))
}

fn write_out(text: &str, progress: &dyn Fn()) -> Result<(), Failure> {
    let mut out = std::io::stdout();
    match write_parts(&mut out, text.as_bytes(), progress).and_then(|()| out.flush()) {
        Err(error) if error.kind() == ErrorKind::BrokenPipe => lookat_image::exit(TROUBLE.into()),
        written => written.map_err(|_| Failure::Unwritten),
    }
}

/// Reports lost output. Returns the exit status.
fn lost() -> u8 {
    say(&format!("error: {}", Failure::Unwritten));
    TROUBLE
}

/// Prints a line to standard error. Ignores a closed standard error.
fn say(line: &str) {
    standard_error::write(format!("{}\n", visible(line)).into_bytes());
}
