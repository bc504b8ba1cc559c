//! `lookat view`: shows a scene in the browser, and follows its file.

mod camera;
mod describe;
mod edit;
mod editor;
mod engine;
mod files;
mod gallery;
mod http;
mod messages;
mod open;
mod outbox;
mod pace;
mod reference;
mod requests;
mod server;
mod socket;
mod timed;
mod unsaved;
mod write;

use std::net::{Ipv4Addr, TcpListener};
use std::path::Path;
use std::process::ExitCode;
use std::sync::Arc;

use lookat_image::{io_reason, open_file};

use crate::args::View;
use crate::standard_error;
use editor::Editor;
use engine::Engine;
use gallery::Gallery;
use outbox::Hub;
use reference::References;
use requests::Requests;
use server::Server;

/// Runs the command until a signal.
pub fn view(arguments: &View) -> ExitCode {
    crate::exit_code(serve(arguments))
}

fn serve(arguments: &View) -> Result<u8, String> {
    if arguments.scene == Path::new("-") {
        return Err("standard input can be read only once: name a file".into());
    }
    if let Err(error) = open_file(&arguments.scene) {
        return Err(format!("cannot read {}: {}", arguments.scene.display(), io_reason(&error)));
    }
    let editor = Editor::new(arguments)?;
    let memory = arguments.memory.budget();
    let mut references = References::new(arguments.reference.clone(), memory);
    if arguments.reference.is_some() {
        references.read();
    }
    if let Some(reason) = references.refused.take() {
        return Err(reason);
    }
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, arguments.port)).map_err(|error| {
        format!("cannot listen at 127.0.0.1:{}: {}; choose another --port", arguments.port, io_reason(&error))
    })?;
    let (requests, hub, gallery) =
        (Arc::new(Requests::default()), Arc::new(Hub::default()), Arc::new(Gallery::default()));
    let server = Server::new(&listener, requests.clone(), hub.clone(), gallery.clone())?;
    let engine = Engine::new(arguments, editor, requests, (hub, gallery), references);
    let address = server.address();
    server.start(listener)?;
    crate::print(&format!("{address}\n"))?;
    standard_error::detach();
    crate::say("open this address in a browser; end with Ctrl-C");
    if arguments.open {
        // The browser may run until the user closes it.
        std::thread::spawn(move || {
            if let Err(reason) = open::in_browser(&address) {
                crate::say(&format!("warning: cannot open a browser: {reason}"));
            }
        });
    }
    engine.run()
}
