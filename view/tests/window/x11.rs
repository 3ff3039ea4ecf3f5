//! Pointer and keys of an X server, moved as a hand moves them (XTEST), and the window that they reach.

use std::sync::OnceLock;
use std::thread::sleep;
use std::time::Duration;

use x11rb::connection::Connection as _;
use x11rb::protocol::xproto::{ConnectionExt as _, ImageFormat, InputFocus, MapState, Window};
use x11rb::protocol::xtest::ConnectionExt as _;
use x11rb::rust_connection::RustConnection;
use x11rb::wrapper::ConnectionExt as _;

const KEY: u8 = 2;
const BUTTON: u8 = 4;
const MOTION: u8 = 6;

pub(crate) struct Display {
    connection: RustConnection,
    root: Window,
}

impl Display {
    pub(crate) fn open() -> Self {
        // A display without clients begins anew, and rejects those who come meanwhile.
        static FIRST: OnceLock<Option<RustConnection>> = OnceLock::new();
        FIRST.get_or_init(|| RustConnection::connect(None).ok().map(|(connection, _)| connection));
        let (connection, screen) = RustConnection::connect(None).expect("a display");
        let root = connection.setup().roots[screen].root;
        Self { connection, root }
    }

    /// Finds the visible window of a size and gives it the focus, since there is no window manager. Returns its corner
    /// on the screen in pixels.
    pub(crate) fn window(&self, size: [u16; 2]) -> Option<[i16; 2]> {
        let tree = self.connection.query_tree(self.root).ok()?.reply().ok()?;
        for window in tree.children {
            let Ok(geometry) = self.connection.get_geometry(window).ok()?.reply() else { continue };
            let Ok(attributes) = self.connection.get_window_attributes(window).ok()?.reply() else {
                continue;
            };
            if [geometry.width, geometry.height] == size && attributes.map_state == MapState::VIEWABLE {
                // To the root first: a window that has the focus already gets no event.
                for focus in [self.root, window] {
                    self.connection.set_input_focus(InputFocus::PARENT, focus, 0u32).ok()?;
                    self.flush();
                }
                self.flush();
                return Some([geometry.x, geometry.y]);
            }
        }
        None
    }

    /// The red, green and blue bytes of a rectangle of the screen.
    pub(crate) fn picture(&self, [x, y]: [i16; 2], [width, height]: [u16; 2]) -> Vec<u8> {
        let format = ImageFormat::Z_PIXMAP;
        let image =
            self.connection.get_image(format, self.root, x, y, width, height, !0).unwrap().reply().unwrap();
        image.data.chunks_exact(4).flat_map(|pixel| [pixel[2], pixel[1], pixel[0]]).collect()
    }

    fn fake(&self, kind: u8, detail: u8, [x, y]: [i16; 2]) {
        self.connection.xtest_fake_input(kind, detail, 0, self.root, x, y, 0).expect("XTEST");
        self.flush();
    }

    fn flush(&self) {
        self.connection.sync().expect("the display");
    }

    pub(crate) fn move_to(&self, at: [i16; 2]) {
        self.fake(MOTION, 0, at);
    }

    /// Presses or releases a button of the pointer; buttons 4 and 5 are the wheel.
    pub(crate) fn button(&self, number: u8, is_down: bool) {
        self.fake(BUTTON + u8::from(!is_down), number, [0, 0]);
    }

    pub(crate) fn click(&self, at: [i16; 2]) {
        self.move_to(at);
        sleep(Duration::from_millis(80));
        self.button(1, true);
        sleep(Duration::from_millis(80));
        self.button(1, false);
        sleep(Duration::from_millis(80));
    }

    pub(crate) fn drag(&self, from: [i16; 2], to: [i16; 2]) {
        self.move_to(from);
        sleep(Duration::from_millis(60));
        self.button(1, true);
        for step in 1..=8 {
            let part = |a: i16, b: i16| a + (b - a) / 8 * step;
            sleep(Duration::from_millis(25));
            self.move_to([part(from[0], to[0]), part(from[1], to[1])]);
        }
        sleep(Duration::from_millis(25));
        self.button(1, false);
    }

    /// The key code of a key symbol, and whether the symbol needs shift.
    fn code(&self, symbol: u32) -> (u8, bool) {
        let setup = self.connection.setup();
        let (first, last) = (setup.min_keycode, setup.max_keycode);
        let map = self.connection.get_keyboard_mapping(first, last - first + 1).unwrap().reply().unwrap();
        let per = usize::from(map.keysyms_per_keycode);
        let at = map.keysyms.iter().position(|known| *known == symbol).expect("a key of the symbol");
        (first + (at / per) as u8, at % per == 1)
    }

    pub(crate) fn key(&self, symbol: u32, is_down: bool) {
        self.fake(KEY + u8::from(!is_down), self.code(symbol).0, [0, 0]);
    }

    /// Presses and releases a key while the keys `held` are pressed.
    pub(crate) fn press(&self, held: &[u32], symbol: u32) {
        held.iter().for_each(|one| self.key(*one, true));
        self.key(symbol, true);
        sleep(Duration::from_millis(30));
        self.key(symbol, false);
        held.iter().rev().for_each(|one| self.key(*one, false));
        sleep(Duration::from_millis(30));
    }

    pub(crate) fn write(&self, text: &str) {
        for character in text.chars() {
            let (_, is_shifted) = self.code(u32::from(character));
            self.press(if is_shifted { &[SHIFT] } else { &[] }, u32::from(character));
        }
    }
}

/// The X11 key symbol of shift; the following constants are those of other keys.
pub(crate) const SHIFT: u32 = 0xffe1;
pub(crate) const CONTROL: u32 = 0xffe3;
pub(crate) const ESCAPE: u32 = 0xff1b;
pub(crate) const BACKSPACE: u32 = 0xff08;
pub(crate) const HOME: u32 = 0xff50;
pub(crate) const RIGHT: u32 = 0xff53;
pub(crate) const DOWN: u32 = 0xff54;
pub(crate) const PAGE_UP: u32 = 0xff55;
pub(crate) const PAGE_DOWN: u32 = 0xff56;
pub(crate) const END: u32 = 0xff57;
pub(crate) const UP: u32 = 0xff52;
pub(crate) const ENTER: u32 = 0xff0d;
pub(crate) const TAB: u32 = 0xff09;
pub(crate) const F6: u32 = 0xffc3;
pub(crate) const F1: u32 = 0xffbe;
pub(crate) const F2: u32 = 0xffbf;
