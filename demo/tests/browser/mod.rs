//! A headless Chromium, driven by its DevTools protocol over a pipe: real input events, no dependencies.

use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

/// Under these names distributions have it.
const NAMES: [&str; 4] = ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable"];
/// A loaded machine may take long; a page that hangs must not take for ever.
const PATIENCE: Duration = Duration::from_secs(90);

/// A page in a browser of its own.
pub struct Page {
    browser: Child,
    requests: ChildStdin,
    messages: Receiver<Value>,
    last_id: u64,
    session: Option<String>,
    /// What the page complained about: exceptions, console errors and warnings.
    pub complaints: Vec<String>,
    /// Every address that was asked for.
    pub requested: Vec<String>,
    /// Events that have come and were not waited for.
    events: Vec<String>,
    _profile: tempfile::TempDir,
}

impl Page {
    /// Opens a file in a window of that many CSS pixels, and waits until it has loaded.
    pub fn open(path: &Path, size: [u32; 2]) -> Self {
        let profile = tempfile::tempdir().unwrap();
        // The protocol's pipes are file descriptors 3 and 4; a shell puts ours there.
        let script = format!(
            "exec \"$0\" --headless --no-sandbox --disable-gpu --disable-dev-shm-usage --no-first-run \
             --user-data-dir='{}' --remote-debugging-pipe 3<&0 4>&1 </dev/null >/dev/null 2>&1",
            profile.path().display()
        );
        let mut browser = Command::new("sh")
            .args(["-c", &script, find()])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let requests = browser.stdin.take().unwrap();
        let answers = BufReader::new(browser.stdout.take().unwrap());
        let (sender, messages) = channel();
        std::thread::spawn(move || {
            for message in answers.split(0) {
                let Ok(message) = message else { return };
                let Ok(()) = sender.send(serde_json::from_slice(&message).unwrap()) else { return };
            }
        });
        let mut page = Self {
            browser,
            requests,
            messages,
            last_id: 0,
            session: None,
            complaints: Vec::new(),
            requested: Vec::new(),
            events: Vec::new(),
            _profile: profile,
        };
        let target = page.call("Target.createTarget", json!({ "url": "about:blank" }));
        let attach = json!({ "targetId": target["targetId"], "flatten": true });
        let session = page.call("Target.attachToTarget", attach);
        page.session = Some(session["sessionId"].as_str().unwrap().to_owned());
        for domain in ["Page", "Runtime", "Log", "Network"] {
            page.call(&format!("{domain}.enable"), json!({}));
        }
        page.resize(size);
        page.call("Page.navigate", json!({ "url": format!("file://{}", path.display()) }));
        page.wait_for("Page.loadEventFired");
        page
    }

    pub fn resize(&mut self, [width, height]: [u32; 2]) {
        let metrics = json!({ "width": width, "height": height, "deviceScaleFactor": 1, "mobile": false });
        self.call("Emulation.setDeviceMetricsOverride", metrics);
    }

    /// The value of an expression, promises awaited.
    pub fn evaluate(&mut self, expression: &str) -> Value {
        let parameters = json!({ "expression": expression, "returnByValue": true, "awaitPromise": true });
        let found = self.call("Runtime.evaluate", parameters);
        assert!(found.get("exceptionDetails").is_none(), "{expression}: {found}");
        found["result"]["value"].clone()
    }

    /// Presses the left button at the first point, moves through the others, and releases it at the last.
    pub fn drag(&mut self, points: &[[f64; 2]]) {
        let (Some(first), Some(last)) = (points.first(), points.last()) else { return };
        self.mouse("mousePressed", *first, 1);
        points.iter().for_each(|point| self.mouse("mouseMoved", *point, 1));
        self.mouse("mouseReleased", *last, 0);
    }

    fn mouse(&mut self, kind: &str, [x, y]: [f64; 2], buttons: u32) {
        let event =
            json!({ "type": kind, "x": x, "y": y, "button": "left", "buttons": buttons, "clickCount": 1 });
        self.call("Input.dispatchMouseEvent", event);
    }

    /// A finger that goes down at the first point, through the others, and up.
    pub fn swipe(&mut self, points: &[[f64; 2]]) {
        self.call("Emulation.setTouchEmulationEnabled", json!({ "enabled": true }));
        for (i, [x, y]) in points.iter().enumerate() {
            let kind = if i == 0 { "touchStart" } else { "touchMove" };
            let event = json!({ "type": kind, "touchPoints": [{ "x": x, "y": y }] });
            self.call("Input.dispatchTouchEvent", event);
        }
        self.call("Input.dispatchTouchEvent", json!({ "type": "touchEnd", "touchPoints": [] }));
        self.call("Emulation.setTouchEmulationEnabled", json!({ "enabled": false }));
    }

    /// Types a key by its name, e.g. `ArrowLeft` or `f`.
    pub fn press(&mut self, key: &str) {
        for kind in ["rawKeyDown", "keyUp"] {
            self.call("Input.dispatchKeyEvent", json!({ "type": kind, "key": key }));
        }
    }

    /// PNG of what the window shows, or of the whole page.
    pub fn screenshot(&mut self, whole: bool) -> Vec<u8> {
        let found = self.call("Page.captureScreenshot", json!({ "captureBeyondViewport": whole }));
        base64::decode(found["data"].as_str().unwrap()).unwrap()
    }

    fn call(&mut self, method: &str, parameters: Value) -> Value {
        self.last_id += 1;
        let mut request = json!({ "id": self.last_id, "method": method, "params": parameters });
        if let Some(session) = &self.session {
            request["sessionId"] = session.as_str().into();
        }
        self.requests.write_all(format!("{request}\0").as_bytes()).unwrap();
        let deadline = Instant::now() + PATIENCE;
        loop {
            let message = self.next(method, deadline);
            if message["id"] == self.last_id {
                assert!(message.get("error").is_none(), "{method}: {}", message["error"]);
                return message["result"].clone();
            }
        }
    }

    fn wait_for(&mut self, event: &str) {
        let deadline = Instant::now() + PATIENCE;
        while !self.events.iter().any(|seen| seen == event) {
            self.next(event, deadline);
        }
    }

    /// The next message, after noting what it says about the page.
    fn next(&mut self, awaited: &str, deadline: Instant) -> Value {
        let left = deadline.saturating_duration_since(Instant::now());
        let message = self.messages.recv_timeout(left);
        let message =
            message.unwrap_or_else(|error| panic!("the browser does not answer {awaited}: {error}"));
        let (event, details) = (message["method"].as_str().unwrap_or(""), &message["params"]);
        let is_complaint = match event {
            "Runtime.exceptionThrown" => true,
            "Runtime.consoleAPICalled" => {
                ["error", "warning", "assert"].iter().any(|kind| details["type"] == *kind)
            }
            "Log.entryAdded" => ["error", "warning"].iter().any(|level| details["entry"]["level"] == *level),
            _ => false,
        };
        if is_complaint {
            self.complaints.push(details.to_string());
        }
        if event == "Network.requestWillBeSent" {
            self.requested.push(details["request"]["url"].as_str().unwrap().to_owned());
        }
        self.events.push(event.to_owned());
        message
    }
}

impl Drop for Page {
    fn drop(&mut self) {
        // Asked first: it ends its helpers, which a kill would leave behind.
        let _ = self.requests.write_all(b"{\"id\":0,\"method\":\"Browser.close\"}\0");
        let deadline = Instant::now() + Duration::from_secs(10);
        while matches!(self.browser.try_wait(), Ok(None)) && Instant::now() < deadline {
            std::thread::sleep(Duration::from_millis(20));
        }
        let _ = self.browser.kill();
        let _ = self.browser.wait();
    }
}

/// The first browser in the search path.
fn find() -> &'static str {
    let is_there = |name: &&str| {
        let folders = std::env::var_os("PATH").unwrap_or_default();
        std::env::split_paths(&folders).any(|folder| folder.join(name).is_file())
    };
    NAMES.into_iter().find(is_there).unwrap_or_else(|| {
        panic!(
            "the test needs a browser: none of {} is installed; `apt-get install chromium`",
            NAMES.join(", ")
        )
    })
}
