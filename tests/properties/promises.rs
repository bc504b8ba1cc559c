//! What the reader promises, whatever it reads.

use lookat_scene::syntax::{Diagnostic, Directive, FileId, Severity, Span, parse};
use lookat_scene::{Loaded, Mesh, Primitive, Scene, Shape};

/// Prints and reads again what a text says; `None` where the text has faults.
pub fn round_trip(text: &[u8]) -> Option<()> {
    let parsed = parse(FileId(0), text);
    check_spans(&parsed.diagnostics, &[text.len()]);
    if !parsed.diagnostics.is_empty() {
        return None;
    }
    let directives: Vec<Directive> = parsed.statements.into_iter().map(|s| s.directive).collect();
    check_printed(&directives);
    Some(())
}

/// Directives read back from their print as they are.
pub fn check_printed(directives: &[Directive]) {
    let text: String = directives.iter().map(|directive| format!("{directive}\n")).collect();
    let again = parse(FileId(0), text.as_bytes());
    assert_eq!(again.diagnostics, [], "{text}");
    let again: Vec<Directive> = again.statements.into_iter().map(|s| s.directive).collect();
    // Printed, because 0 and -0 are equal.
    let printed: String = again.iter().map(|directive| format!("{directive}\n")).collect();
    assert!(again == directives && printed == text, "{text}\nreads back as\n{printed}");
}

/// Places lie in their files, a scene is there when nothing is in error and what is asked for fits it, and it keeps its
/// promises.
pub fn check(loaded: &Loaded) {
    let sizes: Vec<usize> = loaded.sources.files.iter().map(|file| file.text.len()).collect();
    check_spans(&loaded.diagnostics, &sizes);
    let errors =
        loaded.diagnostics.iter().filter(|diagnostic| diagnostic.severity == Severity::Error).count();
    assert_eq!(loaded.scene.is_some(), errors == 0 && loaded.override_error.is_none(), "{errors} errors");
    loaded.scene.iter().for_each(check_scene);
}

fn check_spans(diagnostics: &[Diagnostic], sizes: &[usize]) {
    let inside = |span: Span| span.start <= span.end && span.end as usize <= sizes[span.file.0 as usize];
    for diagnostic in diagnostics {
        let fix = diagnostic.fix.iter().map(|fix| fix.span);
        assert!(diagnostic.labels.iter().map(|label| label.span).chain(fix).all(inside), "{diagnostic:?}");
        assert!(!diagnostic.labels.is_empty() && !diagnostic.message.is_empty(), "{diagnostic:?}");
    }
}

/// A scene is one that can be rendered.
pub fn check_scene(scene: &Scene) {
    assert_eq!(scene.validate(), Ok(()));
    scene.world.shapes().for_each(check_mesh);
}

/// A mesh that is read is one that its constructors make.
fn check_mesh(primitive: &Primitive) {
    let Shape::TriangleMesh(mesh) = &primitive.shape else { return };
    let made = Mesh::new(mesh.positions().to_vec(), mesh.indices().to_vec());
    let with = |made: Mesh| {
        let made =
            if mesh.normals().is_empty() { Ok(made) } else { made.with_normals(mesh.normals().to_vec()) }?;
        let made = if mesh.uvs().is_empty() { Ok(made) } else { made.with_uvs(mesh.uvs().to_vec()) }?;
        if mesh.tangents().is_empty() { Ok(made) } else { made.with_tangents(mesh.tangents().to_vec()) }
    };
    assert!(made.and_then(with).is_ok(), "{mesh:?}");
}
