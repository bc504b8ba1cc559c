//! Standard error: messages, the progress bar, and pictures in the terminal.

use std::collections::VecDeque;
use std::io::{self, IsTerminal, Write};
use std::ops::ControlFlow;
use std::sync::OnceLock;

use indicatif::style::TemplateError;
use indicatif::{ProgressBar, ProgressStyle};

use crate::live::protocol::Drawing;
use crate::readable::plural;
use crate::writer::{Writer, write_parts};

/// Set by [`detach`].
static WRITER: OnceLock<Writer<Item>> = OnceLock::new();

/// The most items that wait, for a terminal that does not read. Further messages are only counted.
const MOST: usize = 1 << 14;

/// What goes to standard error.
enum Item {
    Text(Vec<u8>),
    /// The number of texts that are lost here.
    Lost(u64),
    Bar {
        bar: Bar,
        position: u64,
        message: String,
    },
    NoBar,
    Drawing(Drawing),
}

/// A progress bar with a thousand steps.
#[derive(Clone, Copy)]
pub struct Bar {
    style: fn() -> Result<ProgressStyle, TemplateError>,
    is_hidden: bool,
}

/// From now on, a thread of its own writes standard error, so that a terminal that does not read blocks no other thread.
pub fn detach() {
    if let Ok(writer) = Writer::new(write_items()) {
        let _ = WRITER.set(writer);
    }
}

/// True after [`detach`].
pub fn is_detached() -> bool {
    WRITER.get().is_some()
}

/// Writes text. Styles are left out where the terminal has none. Ignores a closed standard error.
pub fn write(text: Vec<u8>) {
    match WRITER.get() {
        Some(writer) => writer.put(|queue| put(queue, text)),
        None => drop(anstream::stderr().write_all(&text)),
    }
}

/// Adds a text to the queue, or counts it if the queue is full.
fn put(queue: &mut VecDeque<Item>, text: Vec<u8>) {
    if queue.len() < MOST {
        return queue.push_back(Item::Text(text));
    }
    let lost = queue.iter_mut().rev().find_map(|item| match item {
        Item::Lost(count) => Some(count),
        _ => None,
    });
    match lost {
        Some(count) => *count += 1,
        None => queue.push_back(Item::Lost(1)),
    }
}

/// Waits until everything is written. Gives up on a terminal that does not read, and on a pipe where `has_to_end`.
pub fn wait(has_to_end: fn() -> bool) {
    let is_impatient = || io::stderr().is_terminal() || has_to_end();
    if let Some(writer) = WRITER.get() {
        writer.wait(is_impatient);
    }
}

/// True if the terminal has taken all that was written, and a new picture would be drawn at once.
pub fn is_idle() -> bool {
    WRITER.get().is_some_and(Writer::is_idle)
}

/// Draws a picture, in place of the drawings of the same picture that wait.
pub fn draw(drawing: Drawing) {
    WRITER.get().inspect(|writer| {
        writer.put(|queue| {
            queue.retain(|item| !matches!(item, Item::Drawing(other) if other.id == drawing.id));
            queue.push_back(Item::Drawing(drawing));
        });
    });
}

impl Bar {
    /// A bar, hidden if `is_silent` or without a terminal.
    pub fn new(is_silent: bool, style: fn() -> Result<ProgressStyle, TemplateError>) -> Bar {
        Bar { style, is_hidden: is_silent || !is_detached() || !io::stderr().is_terminal() }
    }

    pub fn is_hidden(&self) -> bool {
        self.is_hidden
    }

    /// Shows the bar, if it is not hidden, at a position from 0 to 1000.
    pub fn set(&self, position: u64, message: String) {
        self.put(Item::Bar { bar: *self, position, message });
    }

    /// Removes the bar.
    pub fn clear(&self) {
        self.put(Item::NoBar);
    }

    fn put(&self, item: Item) {
        WRITER.get().filter(|_| !self.is_hidden).inspect(|writer| {
            writer.put(|queue| {
                queue.retain(|item| !matches!(item, Item::Bar { .. }));
                queue.push_back(item);
            });
        });
    }
}

/// Writes items in their order. Texts and pictures go above the bar, and a picture over the drawing before it.
fn write_items() -> impl FnMut(Item, &dyn Fn()) -> ControlFlow<()> + Send {
    let (mut shown, mut drawn) = (None::<ProgressBar>, None::<(u32, u32)>);
    move |item, progress| {
        let above_bar = |out: &mut dyn Write, bytes: &[u8]| {
            let mut write = || write_parts(out, bytes, progress);
            // Ignore a closed standard error.
            let _ = match &shown {
                Some(bar) => bar.suspend(write),
                None => write(),
            };
        };
        match item {
            Item::Text(text) => {
                drawn = None;
                above_bar(&mut anstream::stderr(), &text);
            }
            Item::Lost(count) => {
                drawn = None;
                let messages = plural(count, "message was", "messages were");
                let text = format!("warning: {messages} not shown: standard error was not read in time\n");
                above_bar(&mut anstream::stderr(), text.as_bytes());
            }
            Item::Drawing(drawing) => {
                let before = drawn.filter(|(id, _)| *id == drawing.id).map_or(0, |(_, lines)| lines);
                drawn = Some((drawing.id, drawing.cells[1]));
                above_bar(&mut io::stderr(), &drawing.over(before));
            }
            Item::Bar { bar: Bar { style, .. }, position, message } => {
                let bar = shown.get_or_insert_with(|| {
                    let bar = ProgressBar::new(1000);
                    if let Ok(style) = style() {
                        bar.set_style(style);
                    }
                    bar
                });
                bar.set_message(message);
                bar.set_position(position);
            }
            Item::NoBar => {
                shown.take().inspect(ProgressBar::finish_and_clear);
            }
        }
        ControlFlow::Continue(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_beyond_the_limit_are_counted() {
        let mut queue = VecDeque::new();
        (0..MOST + 3).for_each(|_| put(&mut queue, b"a message\n".to_vec()));
        assert!(queue.len() == MOST + 1 && matches!(queue.back(), Some(Item::Lost(3))));
        // Another item comes after them.
        queue.push_back(Item::NoBar);
        put(&mut queue, b"a message\n".to_vec());
        assert!(queue.len() == MOST + 2 && matches!(queue[MOST], Item::Lost(4)));
    }
}
