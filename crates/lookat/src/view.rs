//! `lookat view`: shows a scene in the browser, and follows its file.

mod camera;
mod editor;
mod engine;
mod http;
mod messages;
mod outbox;
mod reference;
mod server;
mod write;

use std::net::{Ipv4Addr, TcpListener};
use std::path::Path;
use std::process::ExitCode;
use std::sync::Arc;

use lookat_image::{io_reason, open_file};

use crate::args::View;
use crate::failure::Failure;
use crate::standard_error;
use crate::view::editor::Editor;
use crate::view::engine::Engine;
use crate::view::reference::{References, Shared};
use crate::view::server::Server;

/// Runs the command until a signal.
pub fn view(arguments: &View) -> ExitCode {
    crate::exit_code(serve(arguments))
}

fn serve(arguments: &View) -> Result<u8, Failure> {
    if arguments.scene == Path::new("-") {
        bail!("standard input can be read only once: name a file");
    }
    if let Err(error) = open_file(&arguments.scene) {
        bail!("cannot read {}: {}", arguments.scene.display(), io_reason(&error));
    }
    let editor = Editor::new(arguments)?;
    let memory = arguments.memory.budget();
    let mut references = References::new(arguments.reference.clone(), memory);
    if arguments.reference.is_some() {
        references.read();
    }
    if let Some(reason) = references.refused.take() {
        return Err(reason.into());
    }
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, arguments.port)).map_err(|error| {
        format!("cannot listen at 127.0.0.1:{}: {}; choose another --port", arguments.port, io_reason(&error))
    })?;
    let shared = Arc::new(Shared::default());
    let server = Server::new(&listener, shared.clone())?;
    let engine = Engine::new(arguments, editor, shared, references);
    let address = server.address();
    server.start(listener)?;
    crate::print(&format!("{address}\n"))?;
    standard_error::detach();
    say!("open this address in a browser; end with Ctrl-C");
    if arguments.open {
        // The browser may run until the user closes it.
        std::thread::spawn(move || {
            if let Err(reason) = editor::open_in_browser(&address) {
                say!("warning: cannot open a browser: {reason}");
            }
        });
    }
    engine.run()
}
