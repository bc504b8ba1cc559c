//! `lookat-lab against`: compares lookat with pbrt-v3, or with an earlier lookat.

use std::collections::HashMap;
use std::error::Error;
use std::fs;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use clap::Args;
use clap::builder::PossibleValuesParser;
use lookat_image::Image;

use super::{Outcome, Ratio, Row, Run, SIDE, disagreement, pictures, rows};
use crate::estimate::mean;
use crate::table::significant;
use crate::{lookat_program, print, timed};

/// The most runs of a program per row; lookat's differ in seed.
const RUNS: usize = 3;
/// A program that has taken so many seconds for a row does not run again.
const LONG: f64 = 30.0;
/// The seed of references.
const REFERENCE_SEED: usize = 1_000;
/// The first line of `against.csv`.
const HEADER: &str = "row,samples_per_pixel,seconds,error,error_trimmed,pbrt_seconds,pbrt_error,pbrt_error_trimmed,\
                      disagreement";

/// The arguments of `lookat-lab against`.
#[derive(Debug, Args)]
pub struct Against {
    /// pbrt-v3's program
    #[arg(long, value_name = "PATH", required_unless_present = "before")]
    pbrt: Option<PathBuf>,
    /// lookat's program [default: the one beside this program]
    #[arg(long, value_name = "PATH")]
    lookat: Option<PathBuf>,
    /// Only these rows
    #[arg(long, value_name = "ROW,...", value_delimiter = ',', value_parser = names(), hide_possible_values = true)]
    only: Vec<String>,
    /// Samples per pixel, powers of two
    #[arg(long, value_name = "N,...", value_delimiter = ',', default_value = "16,64", value_parser = samples)]
    spp: Vec<u32>,
    /// Samples per pixel of lookat's references, a power of two
    #[arg(long, value_name = "N", default_value = "4096", value_parser = samples)]
    reference_spp: u32,
    /// Folder for scenes, pictures and the table; references in it are used again
    #[arg(short, long, value_name = "FOLDER", default_value = "against")]
    output: PathBuf,
    /// The against.csv of an earlier version: adds columns of its error and time over the present ones
    #[arg(long, value_name = "FILE.csv")]
    before: Option<PathBuf>,
}

fn names() -> PossibleValuesParser {
    PossibleValuesParser::new(rows().into_iter().map(|row| &*row.name.leak()))
}

fn samples(text: &str) -> Result<u32, String> {
    let power = text.parse().ok().filter(|n: &u32| n.is_power_of_two() && *n <= 65_536);
    power.ok_or("needs a power of two up to 65536".into())
}

/// The outcomes of one row at one number of samples.
struct Compared {
    lookat: Outcome,
    pbrt: Option<Outcome>,
    /// What [`disagreement`] says of pbrt-v3's picture.
    disagreement: Option<f64>,
}

/// Outcomes by row and samples per pixel.
type Before = HashMap<(String, u32), Outcome>;

impl Against {
    /// Compares, prints the table and writes it. Fails with the reason.
    pub fn run(&self) -> Result<(), Box<dyn Error>> {
        let before = self.before.as_deref().map(read_before).transpose()?;
        let programs = Programs::find(self)?;
        fs::create_dir_all(&self.output).map_err(|error| of_path(&self.output, error))?;
        for (name, picture) in pictures() {
            picture.write(&self.output.join(name))?;
        }
        let csv_path = self.output.join("against.csv");
        let mut csv = format!("{HEADER}\n");
        let mut lines = Vec::new();
        print(&(self.header() + "\n"))?;
        for row in rows().iter().filter(|row| self.only.is_empty() || self.only.contains(&row.name)) {
            let compared = programs.compare(row, self)?;
            let mut cells = Vec::new();
            for (samples, compared) in self.spp.iter().zip(&compared) {
                csv += &csv_line(&row.name, *samples, compared);
                let before = before.as_ref().map(|before| before.get(&(row.name.clone(), *samples)));
                cells.extend(compared.cells(before));
            }
            print(&(line(&row.name, &cells) + "\n"))?;
            lines.push(cells);
            fs::write(&csv_path, &csv).map_err(|error| of_path(&csv_path, error))?;
        }
        print(&(line("geometric mean", &geometric_means(&lines)) + "\n"))?;
        Ok(())
    }

    /// The first two lines of the table.
    fn header(&self) -> String {
        let mut columns = vec!["row".to_string()];
        for samples in &self.spp {
            if self.pbrt.is_some() {
                columns.push(format!("error over pbrt-v3's, {samples} samples"));
                columns.push(format!("time to equal error, {samples}"));
            }
            if self.before.is_some() {
                columns.push(format!("error, before over now, {samples}"));
                columns.push(format!("time, before over now, {samples}"));
            }
        }
        format!("| {} |\n|{}", columns.join(" | "), "---|".repeat(columns.len()))
    }
}

/// A cell of the table: a ratio, or why there is none.
type Cell = Result<Ratio, String>;

impl Compared {
    fn cells(&self, before: Option<Option<&Outcome>>) -> Vec<Cell> {
        let mut cells = Vec::new();
        let none = || [Err(String::new()), Err(String::new())];
        if let Some(pbrt) = self.pbrt {
            cells.extend(match self.disagreement {
                Some(mean) => {
                    [Err(format!("the pictures differ: mean {:+.1} %", 100.0 * mean)), Err(String::new())]
                }
                None => [self.lookat.error_over(pbrt), self.lookat.time_to_equal_error(pbrt)].map(Ok),
            });
        }
        if let Some(before) = before {
            cells.extend(before.map_or_else(none, |before| {
                let time = Ratio { value: before.seconds / self.lookat.seconds, fireflies: false };
                [before.error_over(self.lookat), time].map(Ok)
            }));
        }
        cells
    }
}

/// A line of the table. Ratios have two significant digits.
fn line(name: &str, cells: &[Cell]) -> String {
    let text = |cell: &Cell| match cell {
        Ok(Ratio { value, fireflies }) => {
            format!("{}{}", significant(*value, 2), if *fireflies { "\\*" } else { "" })
        }
        Err(reason) => reason.clone(),
    };
    format!("| {name} | {} |", cells.iter().map(text).collect::<Vec<_>>().join(" | "))
}

/// The geometric mean of the ratios in each column.
fn geometric_means(lines: &[Vec<Cell>]) -> Vec<Cell> {
    let of_column = |column: usize| {
        let ratios = lines.iter().filter_map(|cells| cells[column].as_ref().ok());
        let value = mean(&ratios.map(|ratio| ratio.value.ln()).collect::<Vec<_>>()).exp();
        if value.is_nan() { Err(String::new()) } else { Ok(Ratio { value, fireflies: false }) }
    };
    (0..lines[0].len()).map(of_column).collect()
}

fn csv_line(row: &str, samples: u32, compared: &Compared) -> String {
    let fields =
        |outcome: Outcome| format!("{:e},{:e},{:e}", outcome.seconds, outcome.error, outcome.trimmed);
    let pbrt = compared.pbrt.map_or(",,".into(), fields);
    let disagreement = compared.disagreement.map_or(String::new(), |mean| format!("{mean:e}"));
    format!("{row},{samples},{},{pbrt},{disagreement}\n", fields(compared.lookat))
}

fn read_before(path: &Path) -> Result<Before, String> {
    let text = fs::read_to_string(path).map_err(|error| of_path(path, error))?;
    let mut lines = text.lines().enumerate();
    if lines.next().is_none_or(|(_, header)| header != HEADER) {
        return Err(format!("{}: not an against.csv: the first line must be {HEADER}", path.display()));
    }
    let parsed = |line: &str| {
        let fields: Vec<&str> = line.split(',').collect();
        let number = |i: usize| fields.get(i)?.parse().ok();
        let outcome = Outcome { seconds: number(2)?, error: number(3)?, trimmed: number(4)? };
        Some(((fields[0].to_string(), fields[1].parse().ok()?), outcome))
    };
    let line_of =
        |(i, line)| parsed(line).ok_or(format!("{}:{}: not a line of against.csv", path.display(), i + 1));
    lines.map(line_of).collect()
}

/// The programs to compare.
struct Programs {
    lookat: PathBuf,
    /// What lookat says of its version.
    version: String,
    pbrt: Option<PathBuf>,
}

impl Programs {
    fn find(args: &Against) -> Result<Programs, Box<dyn Error>> {
        let lookat = lookat_program(args.lookat.as_deref())?;
        let version = printed(Command::new(&lookat).arg("--version"))?;
        if let Some(pbrt) = &args.pbrt {
            // pbrt-v3 ends its help with failure.
            run(Command::new(pbrt).arg("--help"))?;
        }
        Ok(Programs { lookat, version, pbrt: args.pbrt.clone() })
    }

    /// The outcomes of a row at each number of samples.
    fn compare(&self, row: &Row, args: &Against) -> Result<Vec<Compared>, Box<dyn Error>> {
        let reference = self.reference(row, args)?;
        args.spp.iter().map(|samples| self.compare_at(row, *samples, &reference, &args.output)).collect()
    }

    fn compare_at(
        &self,
        row: &Row,
        samples: u32,
        reference: &[[f32; 3]],
        folder: &Path,
    ) -> Result<Compared, Box<dyn Error>> {
        let scene = written(row, samples, folder)?;
        let (mut own, mut other): (Vec<Run>, Vec<Run>) = (Vec::new(), Vec::new());
        for seed in 0..RUNS {
            own.push(self.lookat(&scene, seed)?);
            let is_long = other.iter().map(|run| run.seconds).sum::<f64>() >= LONG;
            if let Some(pbrt) = self.pbrt.as_ref().filter(|_| !is_long) {
                let picture = scene.with_extension("pbrt-v3.exr");
                let command = &mut Command::new(pbrt);
                other.push(rendered(command.args(["--quiet", "--nthreads", "1"]), &scene, &picture)?);
            }
        }
        Ok(Compared {
            lookat: Outcome::of(&own, reference),
            pbrt: (!other.is_empty()).then(|| Outcome::of(&other, reference)),
            disagreement: other.first().and_then(|run| disagreement(&run.pixels, reference)),
        })
    }

    /// The pixels of a row's reference, from the folder if this version has rendered it there.
    fn reference(&self, row: &Row, args: &Against) -> Result<Vec<[f32; 3]>, Box<dyn Error>> {
        let mut hasher = DefaultHasher::new();
        (&self.version, row.text(args.reference_spp)).hash(&mut hasher);
        for (name, picture) in pictures() {
            picture.to_bytes(Path::new(name))?.hash(&mut hasher);
        }
        let kept = args.output.join(format!("{}-{:016x}.exr", row.name, hasher.finish()));
        if !kept.exists() {
            let scene = written(row, args.reference_spp, &args.output)?;
            self.lookat(&scene, REFERENCE_SEED)?;
            fs::rename(scene.with_extension("exr"), &kept).map_err(|error| of_path(&kept, error))?;
        }
        Ok(pixels(&kept)?)
    }

    fn lookat(&self, scene: &Path, seed: usize) -> Result<Run, String> {
        let seed = seed.to_string();
        let command = &mut Command::new(&self.lookat);
        let options = ["render", "--threads", "1", "--seed", &seed];
        rendered(command.args(options), scene, &scene.with_extension("exr"))
    }
}

/// Writes the scene file of a row.
fn written(row: &Row, samples: u32, folder: &Path) -> Result<PathBuf, String> {
    let path = folder.join(format!("{}-{samples}.pbrt", row.name));
    fs::write(&path, row.text(samples)).map_err(|error| of_path(&path, error))?;
    Ok(path)
}

/// Runs a program that renders a scene.
fn rendered(command: &mut Command, scene: &Path, picture: &Path) -> Result<Run, String> {
    let _ = fs::remove_file(picture);
    let (seconds, messages) = timed(|| printed(command.arg("--outfile").arg(picture).arg(scene)));
    let messages = messages?;
    if !picture.exists() {
        let (program, scene) = (command.get_program().display(), scene.display());
        return Err(format!("{program} {scene} wrote no picture; it printed: {messages}"));
    }
    Ok(Run { seconds, pixels: pixels(picture)? })
}

/// What a program prints that must succeed.
fn printed(command: &mut Command) -> Result<String, String> {
    let output = run(command)?;
    let printed = String::from_utf8_lossy(&[output.stdout, output.stderr].concat()).trim().to_string();
    if !output.status.success() {
        return Err(format!("{}: {}: {printed}", command.get_program().display(), output.status));
    }
    Ok(printed)
}

fn run(command: &mut Command) -> Result<Output, String> {
    let started = command.stdin(Stdio::null()).output();
    started.map_err(|error| match error.kind() {
        ErrorKind::NotFound => format!("{}: no such program", command.get_program().display()),
        _ => format!("{}: {error}", command.get_program().display()),
    })
}

fn pixels(path: &Path) -> Result<Vec<[f32; 3]>, String> {
    let image = Image::read(path).map_err(|error| error.to_string())?;
    let pixels = image.rgb().filter(|pixels| pixels.len() == (SIDE * SIDE) as usize);
    pixels.ok_or(format!("{}: not a color picture of {SIDE} x {SIDE} pixels", path.display()))
}

fn of_path(path: &Path, error: std::io::Error) -> String {
    format!("{}: {error}", path.display())
}
