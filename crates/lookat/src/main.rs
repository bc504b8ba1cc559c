//! The program `lookat`. See its `--help`, and README.md.

mod args;
mod chart;
mod check;
mod command_line;
mod compare;
mod convert;
mod directive_text;
mod explain;
mod finished;
mod inspect;
mod interrupt;
mod light;
mod live;
mod lock;
mod metric;
mod noise;
mod output;
mod render;
mod report;
mod sight;
mod source;
mod stability;
mod standard_error;
mod usage;
mod verify;
mod view;
mod visible;
mod writer;

use std::io::{ErrorKind, IsTerminal, Write};
use std::ops::ControlFlow;
use std::process::ExitCode;
use std::sync::mpsc;

use clap::Parser as _;
use visible::{escaped, visible, visible_lines};
use writer::{Writer, write_parts};

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
        args::Command::Render(arguments) => render::render(&arguments),
        args::Command::View(arguments) => view::view(&arguments),
        args::Command::Check(arguments) => check::check(&arguments),
        args::Command::Compare(arguments) => compare::compare(&arguments),
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

/// Why a command ends without its result.
struct Failure {
    message: String,
    /// The exit status.
    status: u8,
}

impl Failure {
    /// The scene does not fit the memory limit.
    fn too_large(message: String) -> Failure {
        Failure { message, status: report::SCENE_FAULT }
    }
}

impl From<String> for Failure {
    fn from(message: String) -> Failure {
        Failure { message, status: TROUBLE }
    }
}

impl From<&str> for Failure {
    fn from(message: &str) -> Failure {
        message.to_owned().into()
    }
}

/// The exit status of a command. Prints its error message.
fn exit_code(result: Result<u8, impl Into<Failure>>) -> ExitCode {
    ExitCode::from(result.unwrap_or_else(|failure| {
        let Failure { message, status } = failure.into();
        say(&format!("error: {message}"));
        status
    }))
}

/// Waits until all messages are written; after a signal, not on a pipe that nobody reads.
fn wait_for_messages() {
    standard_error::wait(|| interrupt::flow().is_break());
}

/// Prints one line of JSON to standard output.
fn print_json(value: &impl serde::Serialize) -> Result<(), String> {
    print(&(escaped(&serde_json::to_string(value).unwrap_or_default()) + "\n"))
}

/// Prints text to standard output. Ends the program if the reader, such as `head`, has closed the pipe. If standard error is detached,
/// gives up on a terminal that does not read, and after a signal also on a pipe.
fn print(text: &str) -> Result<(), String> {
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
    told.try_recv().unwrap_or_else(|_| Err(UNWRITTEN.into()))
}

fn write_out(text: &str, progress: &dyn Fn()) -> Result<(), String> {
    let mut out = std::io::stdout();
    match write_parts(&mut out, text.as_bytes(), progress).and_then(|()| out.flush()) {
        Err(error) if error.kind() == ErrorKind::BrokenPipe => lookat_image::exit(TROUBLE.into()),
        written => written.map_err(|_| UNWRITTEN.into()),
    }
}

/// The error message if the output cannot be written.
const UNWRITTEN: &str = "cannot write the result";

/// Reports lost output. Returns the exit status.
fn lost() -> u8 {
    say(&format!("error: {UNWRITTEN}"));
    TROUBLE
}

/// Prints a line to standard error. Ignores a closed standard error.
fn say(line: &str) {
    standard_error::write(format!("{}\n", visible(line)).into_bytes());
}
