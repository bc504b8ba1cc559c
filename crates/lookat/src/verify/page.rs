//! The report as a self-contained HTML page.

pub mod picture;

use std::cmp::Reverse;
use std::fmt::Write;
use std::fs::File;
use std::io::{self, Read as _, Seek as _, Write as _};
use std::path::Path;

use lookat_image::{ImageError, Measured, Metric, io_reason, write_file};

use crate::failure::Failure;
use crate::output::write_result;
use crate::readable::visible_lines;
use crate::verify::outcome::{Outcome, Verdict, summary};
use crate::verify::page::picture::Picture;
use lookat_sight::digits;

/// A number in the report.
#[derive(Debug, Clone)]
pub struct Figure {
    pub name: String,
    pub text: String,
    /// Its description. May be empty.
    pub meaning: String,
    /// The sort key: larger is worse.
    pub badness: f64,
}

impl Figure {
    pub fn number(name: &str, value: f64, meaning: &str) -> Figure {
        Figure { name: name.into(), text: short(value), meaning: meaning.into(), badness: value.abs() }
    }

    /// A number for which larger is better.
    pub fn likeness(name: &str, value: f64, meaning: &str) -> Figure {
        Figure { badness: -value, ..Figure::number(name, value, meaning) }
    }

    /// A signed percentage.
    pub fn percent(name: &str, share: f64, meaning: &str) -> Figure {
        let text = if share.is_nan() { short(share) } else { format!("{:+.3} %", 100.0 * share) };
        let text = text.replace('-', "\u{2212}");
        Figure { name: name.into(), text, meaning: meaning.into(), badness: share.abs() }
    }
}

/// The scenes of the page. A temporary file holds the pictures, as they do not all fit in memory.
pub struct Page {
    scenes: Vec<Outcome>,
    pictures: File,
}

impl Page {
    pub fn new() -> Result<Page, Failure> {
        let pictures = tempfile::tempfile().map_err(not_stored)?;
        Ok(Page { scenes: Vec::new(), pictures })
    }

    /// Adds a scene and stores its pictures.
    pub fn add(&mut self, mut scene: Outcome) -> Result<(), Failure> {
        for (index, picture) in scene.pictures.iter_mut().enumerate() {
            picture.id = format!("picture-{}-{index}", self.scenes.len());
            let (id, data) = (&picture.id, std::mem::take(&mut picture.data));
            writeln!(self.pictures, "<script type=\"text/plain\" id=\"{id}\">{data}</script>")
                .map_err(not_stored)?;
        }
        self.scenes.push(scene);
        Ok(())
    }

    /// Writes the page. `command` repeats the run.
    pub fn write(&self, file: &Path, title: &str, command: &str) -> Result<(), Failure> {
        let [head, tail] = page(title, command, &self.scenes);
        write_result(file, |path| {
            let mut pictures = &self.pictures;
            pictures.rewind().map_err(|error| ImageError::writing(path, error))?;
            write_file(path, head.as_bytes().chain(pictures).chain(tail.as_bytes()))
        })
    }
}

fn not_stored(error: io::Error) -> String {
    let folder = std::env::temp_dir();
    format!("cannot store the pictures of the report in {}: {}", folder.display(), io_reason(&error))
}

/// A scene with its columns of the table.
struct Row<'s> {
    scene: &'s Outcome,
    columns: Vec<Figure>,
}

/// The page before and after the pictures, in HTML.
fn page(title: &str, command: &str, scenes: &[Outcome]) -> [String; 2] {
    let mut scenes: Vec<Row> = scenes.iter().map(|scene| Row { scene, columns: columns(scene) }).collect();
    let badness = |row: &Row| row.columns.first().map_or(f64::NEG_INFINITY, |first| first.badness);
    scenes.sort_by(|a, b| badness(b).total_cmp(&badness(a)));
    scenes.sort_by_key(|row| Reverse(row.scene.verdict));
    let columns = column_names(&scenes);
    let numbered = || scenes.iter().enumerate();
    let content = |slot: &str| match slot {
        "title" => escape(title),
        "command" => escape(command),
        "style" => STYLE.into(),
        "script" => script(),
        "counts" => {
            let verdicts: Vec<Verdict> = scenes.iter().map(|row| row.scene.verdict).collect();
            summary(&verdicts, |verdict, words| format!("<span class=\"{}\">{words}</span>", verdict.word()))
        }
        "headings" => {
            let heading = |name: &&str| format!("<th scope=\"col\"><button>{}</button></th>", escape(name));
            columns.iter().map(heading).collect()
        }
        "rows" => numbered().map(|(number, row)| table_row(number, row, &columns)).collect(),
        "scenes" => numbered().map(|(number, row)| article(number, row)).collect(),
        "version" => env!("CARGO_PKG_VERSION").into(),
        _ => String::new(),
    };
    let (head, tail) = include_str!("page.html").split_once("{{pictures}}").unwrap_or_default();
    [head, tail].map(|template| fill(template, &content))
}

const STYLE: &str = concat!(include_str!("../../page/viewer.css"), include_str!("page.css"));

/// The script of the page, after the modules that it has in common with the page of `view`.
const MODULES: [&str; 6] = [
    include_str!("../../page/tone.js"),
    include_str!("../../page/ramp.js"),
    include_str!("../../page/paint.js"),
    include_str!("../../page/wipe.js"),
    include_str!("../../page/readout.js"),
    include_str!("page.js"),
];

/// All of it as one module, which imports nothing.
fn script() -> String {
    let lines = MODULES.iter().flat_map(|module| module.lines()).filter(|line| !line.starts_with("import "));
    lines.flat_map(|line| [line, "\n"]).collect()
}

/// Fills each `{{slot}}` of a template.
fn fill(template: &str, content: &dyn Fn(&str) -> String) -> String {
    let mut parts = template.split("{{");
    let mut text = parts.next().unwrap_or_default().to_string();
    for part in parts {
        let (slot, rest) = part.split_once("}}").unwrap_or((part, ""));
        text += &content(slot);
        text += rest;
    }
    text
}

/// Escapes text for HTML elements and attributes.
fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for character in visible_lines(text).chars() {
        match character {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            _ => out.push(character),
        }
    }
    out
}

/// A number with four digits, as a page shows it.
fn short(value: f64) -> String {
    digits(value, 4).replace('-', "\u{2212}").replace("NaN", "\u{2013}").replace("inf", "\u{221e}")
}

/// The names of all columns, in the order of the scenes.
fn column_names<'a>(scenes: &'a [Row]) -> Vec<&'a str> {
    let mut names = Vec::new();
    for figure in scenes.iter().flat_map(|row| &row.columns) {
        if !names.contains(&figure.name.as_str()) {
            names.push(figure.name.as_str());
        }
    }
    names
}

fn badge(verdict: Verdict) -> String {
    let word = verdict.word();
    format!(
        "<span class=\"badge {word}\"><svg aria-hidden=\"true\"><use href=\"#{word}\"/></svg>{word}</span>"
    )
}

fn table_row(number: usize, Row { scene, columns: own }: &Row, columns: &[&str]) -> String {
    let mut row = format!("<tr><th scope=\"row\"><a href=\"#scene-{number}\"><span class=\"thumbnails\">");
    for png in scene.pictures.iter().flat_map(|picture| &picture.thumbnails) {
        let _ = write!(row, "<img alt=\"\" src=\"data:image/png;base64,{png}\">");
    }
    let (name, reason) = (escape(&scene.scene), escape(&scene.reason));
    let _ = write!(row, "</span>{name}</a></th>");
    let _ = write!(
        row,
        "<td data-rank=\"{}\" title=\"{reason}\">{}</td>",
        scene.verdict as u8,
        badge(scene.verdict)
    );
    if own.is_empty() {
        let _ = write!(row, "<td class=\"why\" colspan=\"{}\">{reason}</td>", columns.len().max(1));
        return row + "</tr>\n";
    }
    for name in columns {
        row += &own.iter().find(|figure| figure.name == *name).map_or("<td></td>".into(), cell);
    }
    row + "</tr>\n"
}

fn cell(figure: &Figure) -> String {
    // JavaScript's spelling of infinity.
    let rank = figure.badness.to_string().replace("inf", "Infinity").replace("NaN", "");
    format!("<td data-rank=\"{rank}\" title=\"{}\">{}</td>", escape(&figure.meaning), escape(&figure.text))
}

fn article(number: usize, Row { scene, columns }: &Row) -> String {
    let (name, reason, badge) = (escape(&scene.scene), escape(&scene.reason), badge(scene.verdict));
    let mut article =
        format!("<article id=\"scene-{number}\"><h2>{name}</h2><p class=\"reason\">{badge} {reason}</p>\n");
    article += &messages(scene);
    article += "<div class=\"viewers\">";
    let mut thumbnail = 0;
    for picture in &scene.pictures {
        let (viewer, remarks) = (viewer(thumbnail, picture), remarks(picture).join(" "));
        let _ = writeln!(article, "<div>{viewer}<p class=\"remark\">{remarks}</p></div>");
        thumbnail += picture.thumbnails.len();
    }
    article += "</div>";
    article += "<dl class=\"figures\">";
    for Figure { name, text, meaning, .. } in columns.iter().cloned().chain(details(scene)) {
        let (name, text, meaning) = (escape(&name), escape(&text), escape(&meaning));
        let _ = write!(article, "<div><dt>{name}</dt><dd>{text}</dd><dd>{meaning}</dd></div>");
    }
    article + "</dl></article>\n"
}

/// The messages of the scene file; out of sight if the scene is rendered in spite of them.
fn messages(scene: &Outcome) -> String {
    if scene.messages.is_empty() {
        return String::new();
    }
    let open = if scene.verdict == Verdict::Failed { " open" } else { "" };
    format!(
        "<details{open}><summary>Messages</summary><pre tabindex=\"0\">{}</pre></details>\n",
        escape(scene.messages.trim_end())
    )
}

/// The element that the script fills with the pictures. `thumbnail` is the first of their thumbnails in the row.
fn viewer(thumbnail: usize, picture: &Picture) -> String {
    let Picture { id, width, height, corner: [x, y], reduced, stops, scale, .. } = picture;
    let only = picture.only.map_or(String::new(), |role| format!(" data-only=\"{role}\""));
    format!(
        "<div class=\"viewer\" data-id=\"{id}\"{only} data-thumbnail=\"{thumbnail}\" data-width=\"{width}\" data-height=\"{height}\" \
         data-x=\"{x}\" data-y=\"{y}\" data-reduced=\"{reduced}\" data-stops=\"{stops}\" \
         data-scale=\"{scale:e}\" style=\"--across:{width};--down:{height}\"></div>\n"
    )
}

/// Remarks on how the pictures are shown.
fn remarks(picture: &Picture) -> Vec<String> {
    let Picture { reduced, left_out, stops, .. } = picture;
    let minus = |number: i32| format!("{number:+}").replace('-', "\u{2212}");
    let remarks = [
        (*reduced > 1).then(|| {
            format!("Shown at 1/{reduced} size: each pixel is the mean of {reduced} \u{d7} {reduced}.")
        }),
        (*stops != 0)
            .then(|| format!("Exposure 0 is {} stops here, to make the picture visible.", minus(*stops))),
        (*left_out > 0).then(|| format!("Not shown: {left_out} pixels that only one of the pictures has.")),
        (!picture.finite).then(|| "Magenta: infinite or NaN.".into()),
    ];
    remarks.into_iter().flatten().collect()
}

/// The metrics with a column. The others appear below.
const COLUMNS: [Metric; 4] = [Metric::Error, Metric::Rmse, Metric::Flip, Metric::NoiseP];

/// The columns of the table. Scenes are sorted by the first.
fn columns(outcome: &Outcome) -> Vec<Figure> {
    let mean = outcome.mean.unwrap_or(0.0);
    let found =
        COLUMNS.iter().filter_map(|column| outcome.metrics.iter().find(|line| line.metric == *column));
    let mut columns: Vec<Figure> = found
        .map(|line| match line.metric {
            Metric::Error if mean != 0.0 => {
                Figure::percent("error", line.value / mean, "mean signed error, relative to the mean")
            }
            _ => figure(line),
        })
        .collect();
    if columns.is_empty() {
        return columns;
    }
    if let Some(bias) = outcome.visible_in_mean {
        let meaning = "smallest bias of the mean that would have shown";
        let figure = Figure::number("detectable", bias, meaning);
        let text = match mean {
            0.0 => figure.text,
            mean => format!("{:.3} %", 100.0 * bias / mean.abs()),
        };
        columns.insert(1, Figure { text, ..figure });
    }
    if let (Some(samples), Some(seconds)) = (outcome.samples_per_pixel, outcome.seconds) {
        let figure = Figure::number("samples", f64::from(samples), "samples per pixel");
        columns.push(Figure { text: samples.to_string(), ..figure });
        columns.push(Figure::number("seconds", seconds, "time to render"));
    }
    columns
}

/// The metrics without a column.
fn details(outcome: &Outcome) -> impl Iterator<Item = Figure> {
    outcome.metrics.iter().filter(|line| !COLUMNS.contains(&line.metric)).map(figure)
}

fn figure(line: &Measured) -> Figure {
    let meaning = match line.remark.as_str() {
        "" => line.metric.meaning().to_owned(),
        remark => format!("{}, {remark}", line.metric.meaning()),
    };
    let figure = if line.metric.is_likeness() { Figure::likeness } else { Figure::number };
    figure(line.metric.name(), line.value, &meaning)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scene(name: &str, verdict: Verdict, error: f64) -> Outcome {
        let measured = |metric, value| Measured { metric, value, remark: name.into() };
        Outcome {
            scene: name.into(),
            verdict,
            reason: name.into(),
            updated: false,
            metrics: vec![measured(Metric::Error, error), measured(Metric::P99, 1.0)],
            visible_in_mean: None,
            samples_per_pixel: None,
            seconds: None,
            diagnostics: serde_json::json!([]),
            messages: name.into(),
            mean: Some(1.0),
            pictures: vec![],
        }
    }

    #[test]
    fn text_stays_text() {
        let hostile = "</script></style><b a='1' c=\"2\">&amp; {{rows}}";
        let page = page(hostile, hostile, &[scene(hostile, Verdict::Differs, 0.5)]).concat();
        assert!(!page.contains("<b a=") && !page.contains("c=\"2\""));
        // Title, heading and command; name and reason in row and scene, the messages, the remark of a metric.
        let escaped =
            "&lt;/script&gt;&lt;/style&gt;&lt;b a=&#39;1&#39; c=&quot;2&quot;&gt;&amp;amp; {{rows}}";
        assert_eq!(page.matches(escaped).count(), 3 + 4 + 1 + 1);
    }

    #[test]
    fn nothing_is_fetched() {
        let page = page("title", "command", &[scene("a", Verdict::Agrees, 0.0)]).concat();
        assert!(!page.contains("//fonts") && !page.contains("http:"));
        let [links, parts] = ["https:", "</"].map(|text| [STYLE, &script()].concat().matches(text).count());
        // The source of the colors, in a comment.
        assert_eq!([links, parts], [1, 0]);
        assert!(!script().contains("import "));
    }

    /// The page of `compare --picture` has the same colors.
    #[test]
    fn colors_of_differences_are_those_of_the_library() {
        let table: String = include_str!("../../page/ramp.js").split_whitespace().collect();
        let colors = format!("{:?}", lookat_image::DIFFERENCE_COLORS).replace(' ', "");
        assert!(table.contains(colors.trim_matches(['[', ']'])));
    }

    #[test]
    fn the_worst_comes_first() {
        let scenes = [
            scene("a", Verdict::Agrees, 0.1),
            scene("b", Verdict::Differs, 0.2),
            scene("c", Verdict::Differs, -0.3),
            Outcome { metrics: vec![], ..scene("d", Verdict::Failed, 0.0) },
        ];
        let page = page("title", "command", &scenes).concat();
        let place = |name: &str| page.find(&format!("<h2>{name}</h2>")).unwrap();
        assert!(place("c") < place("b") && place("b") < place("d") && place("d") < place("a"));
        let counts = "4 scenes: <span class=\"agrees\">1 agrees</span>, <span class=\"differs\">2 differ</span>, \
                      <span class=\"failed\">1 failed</span></p>";
        assert!(page.contains(counts));
    }

    #[test]
    fn numbers_are_short() {
        let check = |value, text| assert_eq!(Figure::number("", value, "").text, text);
        check(-36.521_7, "\u{2212}36.52");
        check(3e-9, "3e\u{2212}9");
        check(f64::INFINITY, "\u{221e}");
        check(f64::NAN, "\u{2013}");
        assert_eq!(Figure::percent("", -0.001_23, "").text, "\u{2212}0.123 %");
        assert_eq!(Figure::likeness("", 0.9, "").badness, -0.9);
    }
}
