//! Scene texts without a right picture: they need a message with the right words and place.

use std::panic::catch_unwind;
use std::path::Path;

use lookat_scene::syntax::Severity;

use super::tally::Tally;
use crate::text_scene::ply_header;

/// The texts: see the first line.
const MESSAGES: &str = include_str!("messages.tsv");

/// Checks the texts of a case: each must have exactly one message, with the right severity, words and place. A text with a
/// warning must give a scene, one with an error none.
pub(super) fn messages(case: &str) -> Tally {
    let mut tally = Tally::default();
    for line in MESSAGES.lines() {
        let line = line.replace("\\n", "\n");
        if let [id, severity, text, says, at, mesh @ ..] = &line.split('\t').collect::<Vec<_>>()[..]
            && *id == case
        {
            let severity = if *severity == "warning" { Severity::Warning } else { Severity::Error };
            let answer = catch_unwind(|| problem(severity, text, says, at, &mesh.concat()));
            let problem = answer.unwrap_or_else(|_| Some("panics".into()));
            tally.check(problem.is_none(), || format!("{text}: {}", problem.unwrap_or_default()));
        }
    }
    tally
}

/// What is wrong with the messages of a part of a scene, which may name a mesh with this last vertex and face.
fn problem(severity: Severity, part: &str, says: &str, at: &str, mesh: &str) -> Option<String> {
    let film = if part.contains("Film") { "" } else { r#"Sampler "sobol" Integrator "path" Film "image""# };
    let text = format!("{film}\n{part}\nLightSource \"infinite\"\nShape \"sphere\"\nWorldEnd\n");
    let mesh = format!("{}0 0 0\n0 1 0\n{mesh}\n", ply_header("ascii", 3, 1));
    let read = |path: &Path| Ok(if path.ends_with("mesh.ply") { &mesh } else { &text }.clone().into_bytes());
    let loaded = lookat_scene::load(Path::new("case.pbrt"), &read, &Default::default());
    let [problem] = &loaded.diagnostics[..] else {
        let messages: Vec<&str> = loaded.diagnostics.iter().map(|problem| problem.message.as_str()).collect();
        return Some(format!("not one message but {}: {}", messages.len(), messages.join("; ")));
    };
    let span = problem.span();
    let underlined = text.get(span.start as usize..span.end as usize).unwrap_or_default();
    let line = 1 + text[..text.find(at)?].matches('\n').count();
    let is_right = problem.severity == severity
        && problem.message.contains(says)
        && underlined == at
        && loaded.sources.location(span).line == line
        && loaded.scene.is_some() == (severity == Severity::Warning);
    (!is_right).then(|| format!("{:?} `{}` at `{underlined}`", problem.severity, problem.message))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wrong_message_is_found() {
        let part = "Translate 1 2 3\nCamera \"perspective\"\n\"float fov\" 180\nWorldBegin";
        let (error, warning) = (Severity::Error, Severity::Warning);
        assert_eq!(problem(error, part, "fov must be above 0", "180", ""), None);
        assert!(problem(error, part, "fov must be above 1", "180", "").is_some());
        assert!(problem(error, part, "fov must be above 0", "fov", "").is_some());
        assert!(problem(warning, part, "fov must be above 0", "180", "").is_some());
        assert!(problem(error, "Camera \"perspective\"\nWorldBegin", "fov", "Camera", "").is_some());
    }

    /// The mesh of T7 without its faults.
    #[test]
    fn a_right_mesh_has_no_message() {
        let part = "Camera \"perspective\"\nWorldBegin\nShape \"plymesh\" \"string filename\" \"mesh.ply\"";
        let answer = problem(Severity::Error, part, "", "\"mesh.ply\"", "1 0 0\n3 0 1 2");
        assert_eq!(answer.as_deref(), Some("not one message but 0: "));
    }

    #[test]
    fn every_line_belongs_to_a_case() {
        let ids: Vec<&str> = super::super::cases().iter().map(|case| case.id).collect();
        for line in MESSAGES.lines().skip(1) {
            assert!(ids.contains(&line.split('\t').next().unwrap()), "{line}");
        }
    }
}
