//! `lookat bench`: the speed of lookat on this machine.

use std::fmt::Write;
use std::process::ExitCode;

use lookat_image::io_reason;
use lookat_lab::bench::{BenchTable, Cell, Machine, Suite};
use lookat_lab::latency::latency;
use serde_json::{Value, json};

use crate::args::Bench;

/// With fewer, a measurement that other work disturbs is its own median.
const FEWEST_ROUNDS: u16 = 3;

/// Runs the command.
pub fn bench(arguments: &Bench) -> ExitCode {
    crate::exit_code(run(arguments).map(|()| 0))
}

fn run(arguments: &Bench) -> Result<(), crate::Failure> {
    let Bench { only, view, rounds, json } = arguments;
    let machine = Machine::here();
    if !view.is_empty() {
        let program = std::env::current_exe().map_err(|error| io_reason(&error))?;
        let table = latency(&program, view)?;
        let text = || as_text(&table);
        return if *json {
            crate::print_json(&as_json(&machine, 1, &[table]))
        } else {
            crate::print(&text())
        };
    }
    let mut tables = Vec::new();
    if !json {
        crate::print(&head(&machine, *rounds))?;
    }
    if *rounds < FEWEST_ROUNDS {
        crate::say(&format!("ratios are noisy with fewer than {FEWEST_ROUNDS} rounds: increase --rounds"));
    }
    for suite in Suite::ALL.into_iter().filter(|suite| only.is_empty() || only.contains(suite)) {
        crate::say(&format!("measuring {} ...", suite.name()));
        for table in suite.measure((*rounds).into()) {
            if !json {
                crate::print(&as_text(&table))?;
            }
            tables.push(table);
        }
    }
    if *json { crate::print_json(&as_json(&machine, *rounds, &tables)) } else { Ok(()) }
}

/// The heading: version, machine and number of rounds.
fn head(machine: &Machine, rounds: u16) -> String {
    let Machine { processor, threads, simd } = machine;
    let rounds = match rounds {
        1 => "one round".into(),
        _ => format!("medians of {rounds} rounds; in brackets, half the range in percent"),
    };
    format!(
        "lookat {}, {processor}, threads: {threads}, SIMD: {simd}\n{rounds}\n\n",
        env!("CARGO_PKG_VERSION")
    )
}

/// A table as text, with aligned columns.
fn as_text(table: &BenchTable) -> String {
    let name = table.rows.iter().map(|row| row.name.chars().count()).max().unwrap_or(0);
    let is_spread = table.rows.iter().flat_map(|row| &row.cells).any(|cell| cell.low < cell.high);
    let cells: Vec<Vec<String>> =
        table.rows.iter().map(|row| row.cells.iter().map(|cell| number(cell, is_spread)).collect()).collect();
    let width = |column: usize| {
        let longest = cells.iter().map(|row| row[column].chars().count()).max().unwrap_or(0);
        longest.max(table.columns[column].chars().count()) + 2
    };
    let widths: Vec<usize> = (0..table.columns.len()).map(width).collect();
    let mut text = format!("{}: {}\n", table.name, table.title);
    let mut line = |name_of_row: &str, cells: &mut dyn Iterator<Item = &str>| {
        let _ = write!(text, "  {name_of_row:name$}");
        for (cell, width) in cells.zip(&widths) {
            let _ = write!(text, "{cell:>width$}");
        }
        text.push('\n');
    };
    line("", &mut table.columns.iter().copied());
    for (row, cells) in table.rows.iter().zip(&cells) {
        line(&row.name, &mut cells.iter().map(String::as_str));
    }
    text + "\n"
}

/// A number with three digits and its spread; - where nothing is measured. If only other cells have a spread, pads to the same width.
fn number(cell: &Cell, is_spread: bool) -> String {
    let decimals = match cell.median.abs() {
        ..1e-3 => 6,
        ..0.01 => 5,
        ..0.1 => 4,
        ..1.0 => 3,
        ..10.0 => 2,
        ..100.0 => 1,
        _ => 0,
    };
    let (spread, pad) = (100.0 * cell.spread(), if is_spread { "     " } else { "" });
    match cell.low == cell.high {
        _ if cell.median.is_nan() => format!("-{pad}"),
        true => format!("{:.decimals$}{pad}", cell.median),
        false => format!("{:.decimals$} ({spread:2.0})", cell.median),
    }
}

fn as_json(machine: &Machine, rounds: u16, tables: &[BenchTable]) -> Value {
    let cell = |cell: &Cell| json!({ "median": cell.median, "low": cell.low, "high": cell.high });
    let table = |table: &BenchTable| {
        let rows = table
            .rows
            .iter()
            .map(|row| json!({ "name": row.name, "cells": row.cells.iter().map(cell).collect::<Vec<_>>() }));
        json!({
            "name": table.name, "title": table.title, "columns": table.columns,
            "rows": rows.collect::<Vec<_>>(),
        })
    };
    json!({
        "version": env!("CARGO_PKG_VERSION"), "processor": machine.processor, "threads": machine.threads,
        "simd": machine.simd, "rounds": rounds, "tables": tables.iter().map(table).collect::<Vec<_>>(),
    })
}
