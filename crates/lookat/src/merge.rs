//! `lookat merge`: adds up the parts of a rendering.

use std::ops::Range;
use std::process::ExitCode;

use lookat_image::{Format, Image, MemoryBudget, PictureFile};
use lookat_render::{FilmSums, Layer};

use crate::args::{Merge, Writing};
use crate::failure::Failure;
use crate::light::{map_tones, note_linear};
use crate::output::{check_inputs, check_output, check_replaced, is_interrupted, write_result};
use crate::part::{About, PartFile};
use crate::readable::quoted_file;

/// Runs the command.
pub fn merge(arguments: &Merge) -> ExitCode {
    crate::exit_code(run(arguments).map(|()| 0))
}

fn run(arguments: &Merge) -> Result<(), Failure> {
    let Merge { parts, output, partial, writing } = arguments;
    let Writing { tone, force, quiet, memory } = *writing;
    let mut files = Vec::new();
    for path in parts {
        match PartFile::open(path) {
            Ok(file) => files.push(file),
            Err(_) if is_interrupted(path) && parts.len() > 1 => {
                say!("{} is left out: it is not finished, and has no sums", path.display());
            }
            Err(failure) => return Err(failure),
        }
    }
    if files.is_empty() {
        bail!("none of these files has sums: render the parts again");
    }
    let ranges = check_alike(&files)?;
    let missing = missing(&files[0], &ranges);
    let unfinished = files.iter().find(|file| !file.metadata.complete);
    let is_whole = missing.is_empty() && unfinished.is_none();
    if let Some(file) = unfinished.filter(|_| !partial) {
        let name = file.path.display();
        let way_out = match file.metadata.broken_off {
            Some(_) => format!(", or finish it with `lookat resume {}`", quoted_file(file.path)),
            None => String::new(),
        };
        bail!("{name} is not finished: add up what there is with --partial{way_out}");
    }
    if !is_whole && !partial {
        bail!("{}; to add up what there is, use --partial", listed(&missing, &files[0]));
    }
    let is_exr = Format::from_path(output) == Some(Format::Exr);
    if !is_whole && !is_exr {
        bail!("{}: only an .exr file can store a part; choose one with -o", output.display());
    }
    // That of the first samples names the shapes and materials of the layers.
    let first = files.iter().min_by_key(|file| file.metadata.part.ranges[0].start);
    let first = &first.unwrap_or(&files[0]).metadata;
    let crop = files[0].sums.film.crop;
    check_output(output, [crop.width(), crop.height()])?;
    check_inputs(output, parts)?;
    let samples = files.iter().map(|file| file.metadata.samples_per_pixel).sum();
    if !force {
        check_replaced(output, [crop.width(), crop.height()], Some(samples))?;
    }
    if !quiet {
        note_linear(output, tone);
    }
    let memory = &memory.budget();
    let mut sums = files[0].read(memory)?;
    for file in &files[1..] {
        // Of each file only the sums so far stay.
        let memory = &MemoryBudget::new(memory.left());
        sums.add(&file.read(memory)?).map_err(|error| format!("{}: {error}", file.path.display()))?;
    }
    let mut image = sums.image(true);
    // The layers are in the part with the first samples.
    if let Some(layers) = files.iter().find(|file| file.metadata.part.ranges[0].start == 0) {
        add_layers(&mut image, layers, &sums, memory)?;
    }
    image.metadata = Some(first.whole.clone());
    let mean_samples = sums.mean_samples();
    // With --partial, also if it happens to have all: it can be merged on.
    if !is_whole || *partial && is_exr {
        let (provenance, whole) = (first.part.provenance.clone(), first.whole.clone());
        let complete = unfinished.is_none();
        About { provenance, ranges, complete, whole, broken_off: None }
            .put_into(&mut image, sums.without_state());
    }
    let light = map_tones(&mut image, output, tone);
    write_result(output, |path| image.write(path))?;
    if !quiet {
        let mut so_far = String::new();
        if !missing.is_empty() {
            so_far += &format!("; {}", listed(&missing, &files[0]));
        }
        if let Some(file) = unfinished {
            so_far += &format!("; {} is not finished", file.path.display());
        }
        let samples = (10.0 * mean_samples).round() / 10.0;
        say!("{}: {samples} samples per pixel of {}{so_far}", output.display(), counted(files.len()));
        light.inspect(|light| light.print(output, true));
    }
    Ok(())
}

fn counted(files: usize) -> String {
    if files == 1 { "1 file".into() } else { format!("{files} files") }
}

/// Fails unless all are of one rendering and no two have the same samples. Returns the samples that they have.
fn check_alike(files: &[PartFile]) -> Result<Vec<Range<u32>>, Failure> {
    let [first, others @ ..] = files else { return Ok(Vec::new()) };
    let provenance = &first.metadata.part.provenance;
    for other in others {
        if let Some(difference) = provenance.difference(&other.metadata.part.provenance) {
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
    let all = file.metadata.part.provenance.samples_per_pixel;
    let starts = std::iter::once(0).chain(ranges.iter().map(|range| range.end));
    let ends = ranges.iter().map(|range| range.start).chain([all]);
    starts.zip(ends).filter(|(start, end)| start < end).map(|(start, end)| start..end).collect()
}

/// What is missing, in words: the numbers of parts, if whole parts are missing.
fn listed(missing: &[Range<u32>], file: &PartFile) -> String {
    let provenance = &file.metadata.part.provenance;
    let of = provenance.parts;
    let is_missing = |part: &u32| {
        let own = lookat_render::Part { index: *part, of }.range(provenance.samples_per_pixel);
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

/// Copies the layers of a part except its error layers: the picture already has those of all parts.
fn add_layers(
    image: &mut Image,
    file: &PartFile,
    sums: &FilmSums,
    memory: &MemoryBudget,
) -> Result<(), Failure> {
    let (part, _charge) = PictureFile::open(file.path, memory)?.read()?;
    for mut channel in part.channels {
        if FilmSums::is_channel(&channel.name) || image.channel(&channel.name).is_some() {
            continue;
        }
        if Layer::named("samples").is_some_and(|layer| layer.name_in_file() == channel.name) {
            channel.samples = sums.samples().map(|samples| samples as f32).collect();
        }
        image.channels.push(channel);
    }
    Ok(())
}
