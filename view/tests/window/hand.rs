//! A viewer under a hand: started on a pipeline of its own, moved by pointer and keys, read by its log.

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use serde_json::Value;

use crate::x11::Display;

/// The width and height of the window, in pixels.
pub(crate) const SIZE: [u16; 2] = [1400, 860];

/// The maximum time to wait for an effect. The program is barely optimised and the driver is software.
pub(crate) fn patience() -> Duration {
    Duration::from_secs(crate::random::variable("UMBRAGRAPH_VIEW_PATIENCE", 90))
}

pub(crate) struct Hand {
    child: Child,
    pub(crate) display: Display,
    pub(crate) corner: [i16; 2],
    pub(crate) folder: PathBuf,
}

/// The root folder of the workspace.
pub(crate) fn module() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

impl Hand {
    /// Starts the viewer in a new folder. `prepare` writes further files there and returns further arguments. Returns
    /// `None` if there is no display.
    pub(crate) fn start_with(
        name: &str,
        pipeline: &str,
        prepare: impl FnOnce(&Path) -> Vec<String>,
    ) -> Option<Self> {
        if std::env::var_os("DISPLAY").is_none() {
            println!("skipped: there is no display; `xvfb-run cargo test` brings one");
            return None;
        }
        Some(Self::launch(name, pipeline, prepare))
    }

    fn launch(name: &str, pipeline: &str, prepare: impl FnOnce(&Path) -> Vec<String>) -> Self {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
        let _ = std::fs::remove_dir_all(&folder);
        // The log is not beside the pipeline: whatever is written there is looked at.
        std::fs::create_dir_all(folder.join("log")).unwrap();
        std::fs::write(folder.join("own.json"), pipeline).unwrap();
        let arguments = prepare(&folder);
        let scene = module().join("examples/scenes/courtyard.glb").to_string_lossy().into_owned();
        let scene = ["--scene".to_owned(), scene];
        let scene = scene.into_iter().filter(|_| arguments.iter().all(|one| one != "--scene"));
        let said = std::fs::File::create(folder.join("log/said.txt")).unwrap();
        let display = Display::open();
        let child = Command::new(env!("CARGO_BIN_EXE_umbragraph-view"))
            .current_dir(&folder)
            .env("WINIT_X11_SCALE_FACTOR", "1")
            .env_remove("WAYLAND_DISPLAY")
            .args([
                "own.json",
                "--log-state",
                "log/state.jsonl",
                "--window",
                &format!("{}x{}", SIZE[0], SIZE[1]),
            ])
            .args(["--editor", "sh -c echo>opened.txt.$0.$1 {file} {line}"])
            .args(scene)
            .args(arguments)
            .stdout(Stdio::null())
            .stderr(said)
            .spawn()
            .expect("the viewer");
        let mut hand = Self { child, display, corner: [0; 2], folder };
        // Given the keys until it knows that it has them: it may not have looked yet.
        hand.until("a window with the keys", |hand| {
            let corner = hand.display.window(SIZE);
            sleep(Duration::from_millis(500));
            corner.map(|corner| hand.corner = corner).is_some() && hand.state()["focused"] == true
        });
        hand
    }

    /// The last logged state of the window; `null` before the first.
    pub(crate) fn state(&self) -> Value {
        let text = std::fs::read_to_string(self.folder.join("log/state.jsonl")).unwrap_or_default();
        // The last line may be half.
        let whole = text.rfind('\n').map_or("", |end| &text[..end]);
        whole.lines().next_back().and_then(|line| serde_json::from_str(line).ok()).unwrap_or_default()
    }

    /// Presses a key until the state meets a condition, at most `most` times, and returns the state.
    #[track_caller]
    pub(crate) fn press_until(
        &mut self,
        what: &str,
        (held, key): (&[u32], u32),
        most: usize,
        holds: impl Fn(&Value) -> bool,
    ) -> Value {
        for _ in 0..most {
            let before = self.state()["keyboard"].clone();
            self.display.press(held, key);
            // A control has the keys at once, or never.
            let begin = Instant::now();
            while begin.elapsed() < Duration::from_secs(3) {
                let state = self.state();
                if holds(&state) {
                    return state;
                }
                if state["keyboard"] != before {
                    break;
                }
                sleep(Duration::from_millis(40));
            }
        }
        panic!("no {what}: the keyboard is at {}", self.state()["keyboard"]);
    }

    fn until(&mut self, what: &str, mut holds: impl FnMut(&mut Self) -> bool) {
        let begin = Instant::now();
        while !holds(self) {
            if let Ok(Some(status)) = self.child.try_wait() {
                panic!("waiting for {what} the viewer ended ({status}): {}", self.said());
            }
            let state = || {
                let mut state = self.state();
                state.as_object_mut().map(|state| state.remove("controls"));
                state
            };
            assert!(begin.elapsed() < patience(), "no {what}: {}\n{}", state(), self.said());
            sleep(Duration::from_millis(20));
        }
    }

    /// Waits until the state meets a condition, and returns the state.
    #[track_caller]
    pub(crate) fn wait(&mut self, what: &str, holds: impl Fn(&Value) -> bool) -> Value {
        let mut found = Value::Null;
        self.until(what, |hand| {
            found = hand.state();
            holds(&found)
        });
        found
    }

    /// Waits until no frame is to be drawn and no plan is being made, and returns the state.
    pub(crate) fn settle(&mut self) -> Value {
        let is_idle = |state: &Value| state["busy"] == false && state["frames"].as_u64() > Some(0);
        loop {
            let before = self.wait("settled frame", is_idle);
            sleep(Duration::from_millis(700));
            let after = self.state();
            if is_idle(&after) && ["frames", "plans"].iter().all(|name| before[name] == after[name]) {
                return after;
            }
        }
    }

    /// The rectangle of a control in pixels of the screen: x, y, width and height.
    pub(crate) fn rect(&mut self, name: &str) -> [f64; 4] {
        let mut last = [0.0; 4];
        let mut found = None;
        self.until(&format!("control \"{name}\""), |hand| {
            let state = hand.state();
            let rect: Vec<f64> =
                state["controls"][name].as_array().into_iter().flatten().filter_map(Value::as_f64).collect();
            let Ok(rect) = <[f64; 4]>::try_from(rect) else { return false };
            // It may be on its way, as a menu that opens.
            if rect == last {
                found = Some(rect);
            } else {
                sleep(Duration::from_millis(150));
            }
            last = rect;
            found.is_some()
        });
        let [x, y, width, height] = found.unwrap_or_default();
        [x + f64::from(self.corner[0]), y + f64::from(self.corner[1]), width, height]
    }

    /// A point of a control in pixels of the screen, given as fractions of its width and height.
    pub(crate) fn point(&mut self, name: &str, [across, down]: [f64; 2]) -> [i16; 2] {
        let [x, y, width, height] = self.rect(name);
        [(x + across * width).round() as i16, (y + down * height).round() as i16]
    }

    /// Moves the pointer, and waits until the window has received its position.
    pub(crate) fn move_to(&mut self, at: [i16; 2]) {
        self.display.move_to(at);
        let wanted = [0, 1].map(|axis| f64::from(at[axis] - self.corner[axis]));
        self.wait("pointer", |state| state["pointer"]["at"] == serde_json::json!(wanted));
    }

    /// Presses or releases the left button, and waits until the window has received the event, since its frames may be
    /// long.
    fn button(&mut self, is_down: bool) {
        self.display.button(1, is_down);
        self.wait("button", |state| state["pointer"]["down"] == is_down);
    }

    pub(crate) fn press_at(&mut self, at: [i16; 2]) {
        self.move_to(at);
        self.button(true);
        self.button(false);
    }

    pub(crate) fn drag(&mut self, from: [i16; 2], to: [i16; 2]) {
        self.move_to(from);
        self.button(true);
        for step in 1..=4 {
            self.move_to([0, 1].map(|axis| from[axis] + (to[axis] - from[axis]) / 4 * step));
        }
        self.button(false);
    }

    pub(crate) fn click(&mut self, name: &str) {
        self.click_at(name, [0.5, 0.5]);
    }

    /// Clicks a text field, and waits until it has the keyboard focus.
    pub(crate) fn type_into(&mut self, name: &str) {
        self.click(name);
        self.wait("text with the keys", |state| state["typing"] == true);
    }

    /// Clicks the frame, and waits until no text field has the keyboard focus.
    pub(crate) fn leave_text(&mut self) {
        self.click("frame");
        self.wait("window with the keys", |state| state["typing"] == false);
    }

    /// Clicks a point of a control, given as fractions of its width and height.
    pub(crate) fn click_at(&mut self, name: &str, part: [f64; 2]) {
        let at = self.point(name, part);
        self.press_at(at);
    }

    pub(crate) fn is_running(&mut self) -> bool {
        self.child.try_wait().is_ok_and(|status| status.is_none())
    }

    /// The resident memory of the viewer process, in bytes.
    pub(crate) fn memory(&self) -> u64 {
        let text = std::fs::read_to_string(format!("/proc/{}/statm", self.child.id())).unwrap_or_default();
        text.split(' ').nth(1).and_then(|pages| pages.parse::<u64>().ok()).unwrap_or_default() * 4096
    }

    /// Takes a screenshot with the viewer, and returns the bytes of its file.
    pub(crate) fn screenshot(&mut self) -> Vec<u8> {
        let name = format!("frame-{:03}.png", self.files("frame-").len() + 1);
        self.click("screenshot");
        self.wait("screenshot", |state| state["message"].as_str().is_some_and(|said| said.contains(&name)));
        std::fs::read(self.folder.join(name)).expect("a picture")
    }

    /// The contents of the viewer's standard error.
    pub(crate) fn said(&self) -> String {
        std::fs::read_to_string(self.folder.join("log/said.txt")).unwrap_or_default()
    }

    /// The files of the folder whose names begin with `begin`.
    pub(crate) fn files(&self, begin: &str) -> Vec<PathBuf> {
        let all = std::fs::read_dir(&self.folder).unwrap().map(|one| one.unwrap().path());
        all.filter(|path| path.file_name().unwrap().to_string_lossy().starts_with(begin)).collect()
    }
}

impl Drop for Hand {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
