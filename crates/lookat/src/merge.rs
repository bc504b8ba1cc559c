//! `lookat merge`: adds up the parts of a rendering.

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use lookat_image::{Format, Image, MemoryBudget, PictureFile, read_integers};
use lookat_render::{FilmSums, Layer, SumsHeader};

use crate::args::Merge;
use crate::failure::Failure;
use crate::light::{map_tones, note_linear};
use crate::output::{NewPicture, check_inputs, check_output, check_unfinished, write_result};
use crate::part::{Part, PartMetadata};

/// Runs the command.
pub fn merge(arguments: &Merge) -> ExitCode {
    crate::exit_code(run(arguments).map(|()| 0))
}

/// A part whose header has been read.
struct PartFile<'a> {
    path: &'a Path,
    metadata: PartMetadata,
    sums: SumsHeader,
}

fn run(arguments: &Merge) -> Result<(), Failure> {
    let Merge { parts, output, partial, tone, force, quiet, memory } = arguments;
    let files = parts.iter().map(open).collect::<Result<Vec<_>, _>>()?;
    let ranges = check_alike(&files)?;
    let missing = missing(&files[0], &ranges);
    let is_whole = missing.is_empty();
    if !is_whole && !partial {
        bail!("{}; to add up what there is, use --partial", listed(&missing, &files[0]));
    }
    if !is_whole && Format::from_path(output) != Some(Format::Exr) {
        bail!("{}: only an .exr file can store a part; choose one with -o", output.display());
    }
    let first = &files[0].metadata.part;
    let crop = files[0].sums.film.crop;
    check_output(output, [crop.width(), crop.height()])?;
    check_inputs(output, parts)?;
    let samples: u32 = ranges.iter().map(|range| range.len() as u32).sum();
    if !force {
        let new = NewPicture {
            size: [crop.width(), crop.height()],
            samples_per_pixel: Some(samples.into()),
            is_adaptive: false,
            is_partial: false,
        };
        check_unfinished(output, new, "replace it with --force, or choose another name")?;
    }
    if !quiet {
        note_linear(output, *tone);
    }
    let memory = &memory.budget();
    let mut sums = read(&files[0], memory)?;
    for file in &files[1..] {
        sums.add(&read(file, memory)?).map_err(|error| format!("{}: {error}", file.path.display()))?;
    }
    let mut image = sums.image();
    // The layers are in the part with the first samples.
    if let Some(layers) = files.iter().find(|file| file.metadata.part.ranges[0].start == 0) {
        add_layers(&mut image, layers, samples, memory)?;
    }
    image.metadata = Some(files[0].metadata.whole.clone());
    if !is_whole && let Some((header, integers)) = sums.to_channels() {
        let part = Part::new(first.rendering.clone(), ranges, &header);
        image.metadata = part.metadata(files[0].metadata.whole.clone());
        image.integers = integers;
    }
    let light = map_tones(&mut image, output, *tone);
    write_result(output, |path| image.write(path))?;
    if !quiet {
        let so_far = if is_whole { String::new() } else { format!("; {}", listed(&missing, &files[0])) };
        say!("{}: {samples} samples per pixel of {}{so_far}", output.display(), counted(files.len()));
        light.inspect(|light| light.print(output, true));
    }
    Ok(())
}

fn counted(files: usize) -> String {
    if files == 1 { "1 file".into() } else { format!("{files} files") }
}

/// Reads the header of a part.
fn open(path: &PathBuf) -> Result<PartFile<'_>, Failure> {
    let opened = PictureFile::open(path, &MemoryBudget::default())?;
    let name = path.display();
    let Some(text) = opened.metadata().filter(|text| text.contains("\"part\":")) else {
        bail!(
            "{name} is no part of a rendering: only `lookat render --part` and `lookat merge --partial` write parts"
        );
    };
    let read = || {
        let metadata: PartMetadata = serde_json::from_str(&text).ok()?;
        let sums = metadata.part.sums()?;
        let is_sound = is_sound(&metadata.part) && metadata.part.samples() == sums.samples;
        is_sound.then_some(PartFile { path, metadata, sums })
    };
    Ok(read().ok_or_else(|| format!("{name} is damaged, or of another version of lookat"))?)
}

/// True if its ranges are in order and within the rendering.
fn is_sound(Part { rendering, ranges, .. }: &Part) -> bool {
    let mut end = 0;
    let is_next = |range: &Range<u32>| {
        let is_next = range.start >= end && range.start < range.end;
        end = range.end;
        is_next
    };
    !ranges.is_empty()
        && ranges.iter().all(is_next)
        && end <= rendering.samples_per_pixel
        && (1..=rendering.samples_per_pixel).contains(&rendering.parts)
}

/// Fails unless all are of one rendering and no two have the same samples. Returns the samples that they have.
fn check_alike(files: &[PartFile]) -> Result<Vec<Range<u32>>, Failure> {
    let [first, others @ ..] = files else { return Ok(Vec::new()) };
    let rendering = &first.metadata.part.rendering;
    for other in others {
        if let Some(difference) = rendering.difference(&other.metadata.part.rendering) {
            let [a, b] = [first, other].map(|file| file.path.display());
            bail!("{a} and {b} are no parts of one rendering: {difference}");
        }
    }
    let mut all: Vec<_> = files
        .iter()
        .flat_map(|file| file.metadata.part.ranges.iter().map(move |range| (range, file)))
        .collect();
    all.sort_by_key(|(range, _)| range.start);
    let overlap = all.iter().zip(&all[1..]).find(|((a, _), (b, _))| a.end > b.start);
    if let Some(((_, a), (b_range, b))) = overlap {
        let both = b_range.start;
        if a.path == b.path {
            bail!("{} is named twice", a.path.display());
        }
        bail!(
            "{} and {} overlap: both have sample {both} of each pixel; leave one out",
            a.path.display(),
            b.path.display()
        );
    }
    let mut joined: Vec<Range<u32>> = Vec::new();
    for (range, _) in all {
        match joined.last_mut().filter(|last| last.end == range.start) {
            Some(last) => last.end = range.end,
            None => joined.push(range.clone()),
        }
    }
    Ok(joined)
}

/// The samples that no file has.
fn missing(file: &PartFile, ranges: &[Range<u32>]) -> Vec<Range<u32>> {
    let all = file.metadata.part.rendering.samples_per_pixel;
    let starts = std::iter::once(0).chain(ranges.iter().map(|range| range.end));
    let ends = ranges.iter().map(|range| range.start).chain([all]);
    starts.zip(ends).filter(|(start, end)| start < end).map(|(start, end)| start..end).collect()
}

/// What is missing, in words: the numbers of parts, if whole parts are missing.
fn listed(missing: &[Range<u32>], file: &PartFile) -> String {
    let rendering = &file.metadata.part.rendering;
    let of = rendering.parts;
    let is_missing = |part: &u32| {
        let own = lookat_render::Part { index: *part, of }.range(rendering.samples_per_pixel);
        missing.iter().any(|range| range.start <= own.start && own.end <= range.end)
    };
    let parts: Vec<u32> = (0..of).filter(is_missing).collect();
    let (shown, rest) = parts.split_at(parts.len().min(8));
    let names = shown.iter().map(|part| format!("{part}/{of}")).collect::<Vec<_>>().join(", ");
    let more = if rest.is_empty() { String::new() } else { format!(" and {} more", rest.len()) };
    match parts.len() {
        0 => {
            let Range { start, end } = &missing[0];
            format!("the samples from {start} to {} of each pixel are missing", end - 1)
        }
        1 => format!("part {names} is missing"),
        _ => format!("the parts {names}{more} are missing"),
    }
}

/// Reads the sums of a part.
fn read(file: &PartFile, memory: &MemoryBudget) -> Result<FilmSums, Failure> {
    let (channels, _charge) = read_integers(file.path, memory)?;
    let sums = FilmSums::from_channels(file.sums.clone(), &channels);
    sums.map_err(|error| format!("{}: {error}", file.path.display()).into())
}

/// Adds the layers of a part to the picture.
fn add_layers(
    image: &mut Image,
    file: &PartFile,
    samples: u32,
    memory: &MemoryBudget,
) -> Result<(), Failure> {
    let (part, _charge) = PictureFile::open(file.path, memory)?.read()?;
    let is_layer = |name: &str| {
        !["R", "G", "B"].contains(&name) && !name.starts_with("sums.") && !name.starts_with("splats.")
    };
    for mut channel in part.channels.into_iter().filter(|channel| is_layer(&channel.name)) {
        if Layer::named("samples").is_some_and(|layer| layer.name_in_file() == channel.name) {
            channel.samples.fill(samples as f32);
        }
        image.channels.push(channel);
    }
    Ok(())
}
