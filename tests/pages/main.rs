//! The pages of `lookat view` and of `lookat verify --report`, in a browser, and the server without one.

mod answers;
mod browser;
mod looking;
mod parameters;
mod report;
mod server;
mod view_page;
mod viewer;
mod write;
