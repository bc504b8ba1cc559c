//! The server of `lookat view`: who gets in, and what holds up nobody.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::process::Command;
use std::time::{Duration, Instant};

use crate::viewer::{Page, Viewer};
use serde_json::json;

pub const SCENE: &str = "LookAt 0 1 -5  0 0 0  0 1 0
Camera \"perspective\" \"float fov\" 40
Film \"image\" \"integer xresolution\" 48 \"integer yresolution\" 32
Sampler \"halton\" \"integer pixelsamples\" 8
Integrator \"path\"
WorldBegin
LightSource \"infinite\" \"rgb L\" [1 2 3]
Material \"matte\" \"rgb Kd\" [.5 .4 .3]
Shape \"sphere\"
WorldEnd
";

#[test]
fn every_file_of_the_page_is_served_with_its_rules() {
    let viewer = Viewer::start(SCENE);
    let index = viewer.get("");
    assert!(index.starts_with("HTTP/1.1 200 OK\r\n"), "{index}");
    let head = index.split("\r\n\r\n").next().unwrap();
    for rule in [
        "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; connect-src 'self';",
        "frame-ancestors 'none'",
        "x-content-type-options: nosniff\r\n",
        "cache-control: no-store\r\n",
        "referrer-policy: no-referrer\r\n",
    ] {
        assert!(head.contains(rule), "{rule} {head}");
    }
    assert!(!index.contains("//cdn") && !index.contains("https:"));
    assert!(viewer.get("style.css").contains("\r\ncontent-type: text/css"));
    let mut scripts = vec!["main.js".to_owned()];
    let mut at = 0;
    while let Some(name) = scripts.get(at) {
        let answer = viewer.get(name);
        assert!(answer.starts_with("HTTP/1.1 200 OK\r\n"), "{name}: {answer}");
        assert!(answer.contains("\r\ncontent-type: text/javascript"), "{name}");
        let imports = answer.lines().filter_map(|line| line.strip_prefix("import ")?.split("'./").nth(1));
        for import in imports.map(|rest| rest.trim_end_matches("';").to_owned()) {
            if !scripts.contains(&import) {
                scripts.push(import);
            }
        }
        at += 1;
    }
    assert!(scripts.len() > 4, "{scripts:?}");
}

#[test]
fn strangers_are_refused() {
    let viewer = Viewer::start(SCENE);
    viewer.page().finished();
    let Viewer { host, token, .. } = &viewer;
    let local = host.replace("127.0.0.1", "localhost");
    let wrong = token.chars().rev().collect::<String>();
    let own = format!("Host: {host}\r\n");
    let socket = "Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n";
    let origin = format!("Origin: http://{host}\r\n");
    for (line, headers, status) in [
        (format!("GET /{token}/ HTTP/1.1"), own.clone(), 200),
        (format!("GET /{token}/ HTTP/1.1"), own.clone() + &origin, 200),
        // Without the token, or with a part of it.
        ("GET / HTTP/1.1".into(), own.clone(), 404),
        ("GET // HTTP/1.1".into(), own.clone(), 404),
        ("GET /main.js HTTP/1.1".into(), own.clone(), 404),
        (format!("GET /{wrong}/ HTTP/1.1"), own.clone(), 404),
        (format!("GET /{}/ HTTP/1.1", &token[1..]), own.clone(), 404),
        (format!("GET /{token}0/ HTTP/1.1"), own.clone(), 404),
        // Other places.
        (format!("GET /{token} HTTP/1.1"), own.clone(), 404),
        (format!("GET /{token}/../Cargo.toml HTTP/1.1"), own.clone(), 404),
        (format!("GET /{token}/%2e%2e/scene.pbrt HTTP/1.1"), own.clone(), 404),
        (format!("GET /{token}//etc/passwd HTTP/1.1"), own.clone(), 404),
        (format!("GET /{token}/scene.pbrt HTTP/1.1"), own.clone(), 404),
        // The finished picture, and nothing beside it.
        (format!("GET /{token}/picture.exr HTTP/1.1"), own.clone(), 200),
        (format!("GET /{token}/picture.png HTTP/1.1"), own.clone(), 200),
        (format!("GET /{token}/picture.tga HTTP/1.1"), own.clone(), 404),
        (format!("GET /{token}/PICTURE.EXR HTTP/1.1"), own.clone(), 404),
        (format!("GET /{token}/picture.exr/ HTTP/1.1"), own.clone(), 404),
        (format!("GET /{token}/../picture.exr HTTP/1.1"), own.clone(), 404),
        ("GET /picture.exr HTTP/1.1".into(), own.clone(), 404),
        (format!("GET /{wrong}/picture.exr HTTP/1.1"), own.clone(), 404),
        (format!("POST /{token}/picture.exr HTTP/1.1"), format!("{own}Content-Length: 0\r\n"), 405),
        (format!("GET /{token}/picture.exr HTTP/1.1"), "Host: example.com\r\n".into(), 403),
        (format!("GET /{token}/picture.exr HTTP/1.1"), format!("{own}Origin: http://example.com\r\n"), 403),
        // DNS rebinding: the name of another page that leads here.
        (format!("GET /{token}/ HTTP/1.1"), "Host: example.com\r\n".into(), 403),
        (format!("GET /{token}/ HTTP/1.1"), "Host: 127.0.0.1\r\n".into(), 403),
        (format!("GET /{token}/ HTTP/1.1"), format!("Host: {local}\r\n"), 200),
        (format!("GET /{token}/socket HTTP/1.1"), format!("Host: {local}\r\n{origin}{socket}"), 403),
        (format!("GET /{token}/ HTTP/1.1"), String::new(), 403),
        (format!("GET /{token}/ HTTP/1.1"), format!("{own}Host: example.com\r\n"), 403),
        // Other pages.
        (format!("GET /{token}/ HTTP/1.1"), format!("{own}Origin: http://example.com\r\n"), 403),
        (
            format!("POST /{token}/ HTTP/1.1"),
            format!("{own}Origin: http://example.com\r\nContent-Length: 0\r\n"),
            405,
        ),
        (format!("POST /{token}/ HTTP/1.1"), format!("{own}{origin}Content-Length: 0\r\n"), 405),
        (format!("GET /{token}/socket HTTP/1.1"), format!("{own}{origin}{socket}"), 101),
        (format!("GET /{token}/socket HTTP/1.1"), format!("{own}{socket}"), 403),
        (format!("GET /{token}/socket HTTP/1.1"), format!("{own}{socket}Origin: null\r\n"), 403),
        (format!("GET /{token}/socket HTTP/1.1"), format!("{own}{socket}Origin: https://{host}\r\n"), 403),
        (
            format!("GET /{token}/socket HTTP/1.1"),
            format!("{own}{socket}Origin: http://example.com\r\n"),
            403,
        ),
        (format!("GET /{wrong}/socket HTTP/1.1"), format!("{own}{origin}{socket}"), 404),
        (format!("GET /{token}/socket HTTP/1.1"), format!("{own}{origin}"), 400),
        // Malformed.
        ("\u{1}\u{2}\u{3}".into(), String::new(), 400),
        (format!("GET /{token}/ HTTP/7"), own.clone(), 400),
        (format!("GET /{token}/ HTTP/1.1"), format!("{own}no header\r\n"), 400),
        (format!("GET /{token}/ HTTP/1.1"), format!("{own}A: {}\r\n", "a".repeat(100_000)), 431),
        (format!("GET /{token}/ HTTP/1.1"), own.clone() + &"A: a\r\n".repeat(1000), 431),
    ] {
        let answer = viewer.ask(&format!("{line}\r\n{headers}\r\n"));
        let found: Option<u16> = answer.get(9..12).and_then(|status| status.parse().ok());
        assert_eq!(found, Some(status), "{line} {headers:.300} {answer:.300}");
        assert!(status == 200 || !answer.contains(token.as_str()));
    }
    assert_eq!(viewer.text(), SCENE);
}

#[test]
fn clients_that_stall_are_closed_and_hold_up_nobody() {
    let viewer = Viewer::start(SCENE);
    let started = Instant::now();
    let mut stalled: Vec<TcpStream> = (0..31).map(|_| viewer.connect()).collect();
    for stream in &mut stalled {
        stream.write_all(b"GET / HT").unwrap();
    }
    assert!(viewer.get("").starts_with("HTTP/1.1 200"));
    let mut answer = String::new();
    stalled[0].read_to_string(&mut answer).unwrap();
    assert!(answer.starts_with("HTTP/1.1 408"), "{answer}");
    let time = started.elapsed();
    assert!(time > Duration::from_secs(4) && time < Duration::from_secs(20), "{time:?}");
}

#[test]
fn many_connections_are_survived() {
    let viewer = Viewer::start(SCENE);
    for _ in 0..4 {
        let mut open: Vec<TcpStream> = (0..250).map(|_| viewer.connect()).collect();
        // Only so many are served; the oldest of them is closed at once.
        let oldest = &mut open[0];
        oldest.set_read_timeout(Some(Duration::from_secs(2))).unwrap();
        // It may also be reset.
        let closed = oldest.read(&mut [0; 1]);
        let is_reset = |error: &std::io::Error| error.kind() == std::io::ErrorKind::ConnectionReset;
        assert!(matches!(&closed, Ok(0)) || closed.as_ref().is_err_and(is_reset), "{closed:?}");
    }
    let end = Instant::now() + Duration::from_secs(10);
    while !viewer.get("").starts_with("HTTP/1.1 200") {
        assert!(Instant::now() < end);
        std::thread::sleep(Duration::from_millis(50));
    }
}

/// Who has not shown the token makes room for the user's own pages, which stay.
#[test]
fn idle_connections_lock_nobody_out() {
    let viewer = Viewer::start(SCENE);
    let mut page = viewer.page();
    page.finished();
    let mut idle: Vec<TcpStream> = (0..100).map(|_| viewer.connect()).collect();
    let mut other = viewer.page();
    // Sooner than the server gives the others up.
    idle[99].set_read_timeout(Some(Duration::from_millis(100))).unwrap();
    assert!(idle[99].read(&mut [0; 1]).is_err());
    other.finished();
    page.request(&json!({"type": "view", "by": 1, "number": 2, "camera": {"fov": 20}}));
    other.picture(|picture| picture.is_final && picture.number == 2);
    // The user's own pages make no room.
    let _pages: Vec<Page> = (0..30).map(|_| viewer.page()).collect();
    let mut late = viewer.connect();
    assert!(matches!(late.read(&mut [0; 1]), Ok(0)));
    page.request(&json!({"type": "view", "by": 1, "number": 3, "camera": {}}));
    page.picture(|picture| picture.is_final && picture.number == 3);
}

/// Questions that come faster than answers wait: each gets its own.
#[test]
fn a_flood_of_requests_is_answered() {
    const EDITS: usize = 500;
    let viewer = Viewer::start(SCENE);
    let mut page = viewer.page();
    page.finished();
    for by in 0..EDITS {
        page.request(&json!({"type": "edit", "by": by, "action": "undo"}));
    }
    let mut answered = std::collections::BTreeSet::new();
    while answered.len() < EDITS {
        let edited = page.news("edited", |_| true);
        assert_eq!(edited["refused"], "there is nothing to undo");
        answered.insert(edited["by"].as_u64().unwrap());
    }
}

/// `--open` leaves nothing in the folder for temporary files, however soon the program ends.
#[cfg(target_os = "linux")]
#[test]
fn the_page_for_the_browser_is_removed() {
    use std::os::unix::fs::PermissionsExt;

    let folder = tempfile::tempdir().unwrap();
    let [scene, opener, opened, temporary] =
        ["scene.pbrt", "xdg-open", "opened", "temporary"].map(|name| folder.path().join(name));
    std::fs::write(&scene, SCENE).unwrap();
    std::fs::create_dir(&temporary).unwrap();
    let script = format!("#!/bin/sh\ncp \"$1\" {0}.new && mv {0}.new {0}\n", opened.display());
    std::fs::write(&opener, script).unwrap();
    std::fs::set_permissions(&opener, std::fs::Permissions::from_mode(0o755)).unwrap();
    let path = format!("{}:{}", folder.path().display(), std::env::var("PATH").unwrap());
    let names = || std::fs::read_dir(&temporary).unwrap().count();
    let run = |signal: &str| {
        let mut process = Command::new(env!("CARGO_BIN_EXE_lookat"))
            .args(["view", "--open"])
            .arg(&scene)
            .env("PATH", &path)
            .env("TMPDIR", &temporary)
            .stdout(std::process::Stdio::null())
            .stderr(std::process::Stdio::null())
            .spawn()
            .unwrap();
        let end = Instant::now() + Duration::from_secs(60);
        while !opened.exists() {
            assert!(Instant::now() < end);
            std::thread::sleep(Duration::from_millis(10));
        }
        let (page, mode) = (std::fs::read_to_string(&opened).unwrap(), |it: std::fs::DirEntry| {
            it.metadata().unwrap().permissions().mode() & 0o777
        });
        assert!(page.contains("url=http://127.0.0.1:"), "{page}");
        let modes: Vec<u32> = std::fs::read_dir(&temporary).unwrap().map(|it| mode(it.unwrap())).collect();
        assert_eq!(modes, [0o600]);
        std::fs::remove_file(&opened).unwrap();
        assert!(Command::new("kill").args([signal, &process.id().to_string()]).status().unwrap().success());
        process.wait().unwrap();
    };
    run("-TERM");
    assert_eq!(names(), 0);
    // Who is killed cannot clear up: the next one does.
    run("-KILL");
    assert_eq!(names(), 1);
    run("-INT");
    assert_eq!(names(), 0);
}

#[test]
fn nonsense_ends_only_its_own_connection() {
    let viewer = Viewer::start(SCENE);
    let mut good = viewer.page();
    good.finished();
    let view = json!({"type": "view", "by": 1, "number": 2, "camera": {}}).to_string();
    for nonsense in [
        "{".to_owned(),
        "[]".into(),
        json!({"type": "write"}).to_string(),
        json!({"type": "view", "by": 1, "number": 2, "camera": {"shutter": 1}}).to_string(),
        json!({"type": "view", "by": 1, "number": 2, "camera": {"lookAt": [1, 2]}}).to_string(),
        json!({"type": "view", "by": -1, "number": 2, "camera": {}}).to_string(),
        json!({"type": "layer", "layer": 256}).to_string(),
        json!({"type": "values", "by": 1, "number": 2, "at": [1]}).to_string(),
        json!({"type": "errors"}).to_string(),
        json!({"type": "reference", "from": "/etc/passwd"}).to_string(),
        json!({"type": "reference", "from": "file", "file": "/etc/passwd"}).to_string(),
        view.clone() + &" ".repeat(1 << 16),
    ] {
        let mut page = viewer.page();
        page.send(&nonsense);
        assert!(page.is_ended(), "{nonsense:.100}");
    }
    let mut page = viewer.page();
    page.binary(vec![0; 100]);
    assert!(page.is_ended());
    good.send(&view);
    good.finished();
    assert_eq!(viewer.text(), SCENE);
}

#[test]
fn a_page_that_takes_no_pictures_is_closed_and_holds_up_nobody() {
    let large =
        SCENE.replace("48", "1000").replace("32", "1000").replace("pixelsamples\" 8", "pixelsamples\" 1");
    let viewer = Viewer::start(&large);
    let mut stalled = viewer.page();
    let mut page = viewer.page();
    let started = Instant::now();
    let mut number = 0;
    // Pictures are larger than what the system keeps of a connection.
    while started.elapsed() < Duration::from_secs(9) {
        number += 1;
        page.request(&json!({"type": "view", "by": 1, "number": number, "camera": {"fov": 40 + number % 2}}));
        page.picture(|picture| picture.is_final && picture.number == number);
    }
    assert!(number > 3, "{number}");
    assert!(stalled.is_ended());
}
