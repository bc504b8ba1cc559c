//! Chromium without a window, through the pipe of its DevTools protocol.

use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

use base64::prelude::{BASE64_STANDARD, Engine};
use serde_json::{Value, json};
use tempfile::TempDir;

const PATIENCE: Duration = Duration::from_secs(60);

/// The protocol is on the file descriptors 3 and 4.
const START: &str = r#"exec "$0" "$@" 3<&0 4>&1 </dev/null >/dev/null 2>&1"#;

pub struct Browser {
    process: Child,
    commands: ChildStdin,
    messages: Receiver<Value>,
    /// The page is spoken to in this session.
    session: Option<String>,
    sent: u64,
    /// The address of the page.
    own: String,
    /// Errors of the page, and all that it asked the network for beside its own files.
    pub faults: Vec<String>,
    _profile: TempDir,
}

/// The program: the environment variable CHROMIUM, or one of the usual names. `None` skips a test.
///
/// # Panics
///
/// There is no browser, and the environment variable CI is set.
pub fn find() -> Option<PathBuf> {
    let named = std::env::var_os("CHROMIUM").map(PathBuf::from);
    let folders = std::env::var_os("PATH").unwrap_or_default();
    let names = ["chromium", "chromium-browser", "google-chrome", "chrome"];
    let mut usual =
        std::env::split_paths(&folders).flat_map(|folder| names.map(|name| folder.join(name)).into_iter());
    let found = named.or_else(|| usual.find(|path| path.is_file())).filter(|_| cfg!(unix));
    if found.is_none() {
        let missing = "no Chromium on PATH, nor in the environment variable CHROMIUM";
        assert!(std::env::var_os("CI").is_none(), "{missing}");
        println!("skipped: {missing}");
    }
    found
}

impl Browser {
    pub fn start(program: &Path) -> Browser {
        let profile = tempfile::tempdir().unwrap();
        let mut process = Command::new("sh")
            .args(["-c", START])
            .arg(program)
            .args([
                "--headless=new",
                "--remote-debugging-pipe",
                "--no-first-run",
                "--no-default-browser-check",
            ])
            // The only page is our own, and neither root nor a container can have the sandbox.
            .args(["--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--hide-scrollbars"])
            .args(["--disable-background-networking", "--force-color-profile=srgb"])
            .arg(format!("--user-data-dir={}", profile.path().display()))
            .env("TMPDIR", profile.path())
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let (sender, messages) = channel();
        let answers = BufReader::new(process.stdout.take().unwrap());
        std::thread::spawn(move || {
            for message in answers.split(0).map_while(Result::ok) {
                let Ok(message) = serde_json::from_slice(&message) else { break };
                if sender.send(message).is_err() {
                    break;
                }
            }
        });
        let commands = process.stdin.take().unwrap();
        let mut browser = Browser {
            process,
            commands,
            messages,
            session: None,
            sent: 0,
            own: "file:".into(),
            faults: vec![],
            _profile: profile,
        };
        let target = browser.call("Target.createTarget", json!({"url": "about:blank"}))["targetId"].clone();
        let session = browser.call("Target.attachToTarget", json!({"targetId": target, "flatten": true}));
        browser.session = session["sessionId"].as_str().map(String::from);
        for domain in ["Page", "Runtime", "Log", "Network"] {
            browser.call(&format!("{domain}.enable"), json!({}));
        }
        browser
    }

    /// Sends a command and waits for its result.
    pub fn call(&mut self, method: &str, parameters: Value) -> Value {
        self.sent += 1;
        let mut command = json!({"id": self.sent, "method": method, "params": parameters});
        if let Some(session) = &self.session {
            command["sessionId"] = json!(session);
        }
        self.commands.write_all(format!("{command}\0").as_bytes()).unwrap();
        let id = json!(self.sent);
        let mut answer = self.wait(&|message| message["id"] == id);
        assert!(answer["error"].is_null(), "{method}: {answer}");
        answer["result"].take()
    }

    /// Waits for a message, and looks at all that come before.
    fn wait(&mut self, is_it: &dyn Fn(&Value) -> bool) -> Value {
        let end = Instant::now() + PATIENCE;
        loop {
            let left = end.saturating_duration_since(Instant::now());
            let message = self.messages.recv_timeout(left).expect("the browser does not answer");
            self.faults.extend(fault(&message, &self.own));
            if is_it(&message) {
                return message;
            }
        }
    }

    /// Opens a page. All that it needs is below its address.
    pub fn visit(&mut self, address: &str) {
        self.own = address.into();
        self.call("Page.navigate", json!({"url": address}));
        self.wait(&|message| message["method"] == "Page.loadEventFired");
    }

    /// The value of an expression, when its promise is kept.
    pub fn evaluate(&mut self, expression: &str) -> Value {
        let parameters = json!({"expression": expression, "awaitPromise": true, "returnByValue": true});
        let mut answer = self.call("Runtime.evaluate", parameters);
        assert!(answer["exceptionDetails"].is_null(), "{expression}: {answer}");
        answer["result"]["value"].take()
    }

    /// Waits until an expression is true.
    pub fn wait_for(&mut self, expression: &str) {
        let end = Instant::now() + PATIENCE;
        while self.evaluate(expression) != json!(true) {
            assert!(Instant::now() < end, "in vain: {expression}");
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    /// The size of the window in pixels.
    pub fn resize(&mut self, width: u32, height: u32) {
        let size = json!({"width": width, "height": height, "deviceScaleFactor": 1, "mobile": false});
        self.call("Emulation.setDeviceMetricsOverride", size);
    }

    pub fn prefer(&mut self, scheme: &str) {
        let features = json!([{"name": "prefers-color-scheme", "value": scheme}]);
        self.call("Emulation.setEmulatedMedia", json!({"features": features}));
    }

    /// `kind` is mousePressed, mouseMoved or mouseReleased.
    pub fn mouse(&mut self, kind: &str, [x, y]: [f64; 2]) {
        let event = json!({"type": kind, "x": x, "y": y, "button": "left", "buttons": 1, "clickCount": 1});
        self.call("Input.dispatchMouseEvent", event);
    }

    pub fn click(&mut self, place: [f64; 2]) {
        self.mouse("mousePressed", place);
        self.mouse("mouseReleased", place);
    }

    /// Fingers at these places; `kind` is touchStart, touchMove or touchEnd.
    pub fn touch(&mut self, kind: &str, places: &[[f64; 2]]) {
        let points: Vec<Value> =
            places.iter().enumerate().map(|(id, [x, y])| json!({"x": x, "y": y, "id": id})).collect();
        self.call("Input.dispatchTouchEvent", json!({"type": kind, "touchPoints": points}));
    }

    /// A key that is not a character, with its Windows code.
    pub fn press(&mut self, key: &str, code: u32) {
        for kind in ["rawKeyDown", "keyUp"] {
            let event = json!({"type": kind, "key": key, "code": key, "windowsVirtualKeyCode": code});
            self.call("Input.dispatchKeyEvent", event);
        }
    }

    /// The window, as a PNG file.
    pub fn screenshot(&mut self) -> Vec<u8> {
        let answer = self.call("Page.captureScreenshot", json!({"format": "png"}));
        BASE64_STANDARD.decode(answer["data"].as_str().unwrap()).unwrap()
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        // The profile can be removed when nothing writes there anymore.
        let _ = self.commands.write_all(b"{\"id\":0,\"method\":\"Browser.close\"}\0");
        let end = Instant::now() + Duration::from_secs(5);
        while matches!(self.process.try_wait(), Ok(None)) && Instant::now() < end {
            std::thread::sleep(Duration::from_millis(10));
        }
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// What a message says that should not be, of a page at this address.
fn fault(message: &Value, own: &str) -> Option<String> {
    let parameters = &message["params"];
    let url = parameters["request"]["url"].as_str().unwrap_or_default();
    let is_fault = match message["method"].as_str()? {
        "Runtime.exceptionThrown" => true,
        "Runtime.consoleAPICalled" => parameters["type"] == "error",
        "Log.entryAdded" => parameters["entry"]["level"] == "error",
        "Network.requestWillBeSent" => ![own, "data:", "blob:"].iter().any(|start| url.starts_with(start)),
        _ => false,
    };
    is_fault.then(|| message.to_string())
}
