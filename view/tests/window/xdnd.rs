//! A file dropped on the window, as a file manager drops it: the protocol XDND, version 5
//! (<https://www.freedesktop.org/wiki/Specifications/XDND/>).
//!
//! The test program is the source. It owns the selection, announces itself to the window, hands out the file's name
//! when the window asks for it, and lets go.

use std::path::Path;
use std::time::{Duration, Instant};

use x11rb::COPY_DEPTH_FROM_PARENT;
use x11rb::connection::Connection as _;
use x11rb::protocol::Event;
use x11rb::protocol::xproto::{
    Atom, ClientMessageEvent, ConnectionExt as _, CreateWindowAux, EventMask, PropMode,
    SELECTION_NOTIFY_EVENT, SelectionNotifyEvent, SelectionRequestEvent, Window, WindowClass,
};
use x11rb::rust_connection::RustConnection;
use x11rb::wrapper::ConnectionExt as _;

struct Source {
    connection: RustConnection,
    root: Window,
    own: Window,
    text: Vec<u8>,
    list: Atom,
}

/// Drops a file on the window, at a point in pixels of the screen.
pub(crate) fn drop_file(path: &Path, at: [i16; 2]) {
    let (connection, screen) = RustConnection::connect(None).expect("a display");
    let root = connection.setup().roots[screen].root;
    let own = connection.generate_id().unwrap();
    let aux = CreateWindowAux::new();
    connection
        .create_window(COPY_DEPTH_FROM_PARENT, own, root, 0, 0, 1, 1, 0, WindowClass::INPUT_OUTPUT, 0, &aux)
        .unwrap();
    let text = format!("file://{}\r\n", path.canonicalize().unwrap().display()).into_bytes();
    let mut source = Source { list: 0, connection, root, own, text };
    source.list = source.atom("text/uri-list");
    source.drop(at);
}

impl Source {
    fn atom(&self, name: &str) -> Atom {
        self.connection.intern_atom(false, name.as_bytes()).unwrap().reply().unwrap().atom
    }

    fn drop(&self, [x, y]: [i16; 2]) {
        let [selection, enter, position, let_go, status, finished, copy] = [
            "XdndSelection",
            "XdndEnter",
            "XdndPosition",
            "XdndDrop",
            "XdndStatus",
            "XdndFinished",
            "XdndActionCopy",
        ]
        .map(|name| self.atom(name));
        let target = self.target();
        self.connection.set_selection_owner(self.own, selection, 0u32).unwrap();
        let place = (u32::from(x.unsigned_abs()) << 16) | u32::from(y.unsigned_abs());
        self.send(target, enter, [self.own, 5 << 24, self.list, 0, 0]);
        self.send(target, position, [self.own, 0, place, 0, copy]);
        // The window may ask for the name now or after its answer; it has to know it before the drop.
        let mut is_named = false;
        let mut is_accepted = false;
        while !(is_named && is_accepted) {
            match self.next("accepts nothing") {
                Event::SelectionRequest(request) => {
                    self.answer(&request);
                    is_named = true;
                }
                Event::ClientMessage(message) if message.type_ == status => {
                    is_accepted = message.data.as_data32()[1] & 1 == 1;
                    assert!(is_accepted, "the window rejects the file");
                }
                _ => {}
            }
        }
        self.send(target, position, [self.own, 0, place, 0, copy]);
        while !matches!(self.next("has no position"), Event::ClientMessage(one) if one.type_ == status) {}
        self.send(target, let_go, [self.own, 0, 0, 0, 0]);
        while !matches!(self.next("never ends the drop"), Event::ClientMessage(one) if one.type_ == finished)
        {
        }
    }

    /// The window that accepts drops.
    fn target(&self) -> Window {
        let aware = self.atom("XdndAware");
        let tree = self.connection.query_tree(self.root).unwrap().reply().unwrap();
        let takes = |window: &Window| {
            let property = self.connection.get_property(false, *window, aware, 0u32, 0, 1).unwrap().reply();
            property.is_ok_and(|property| property.value_len > 0)
        };
        tree.children.into_iter().find(takes).expect("a window that takes drops")
    }

    fn send(&self, target: Window, kind: Atom, data: [u32; 5]) {
        let message = ClientMessageEvent::new(32, target, kind, data);
        self.connection.send_event(false, target, EventMask::NO_EVENT, message).unwrap();
        self.connection.sync().unwrap();
    }

    /// Answers a selection request with the name of the file.
    fn answer(&self, request: &SelectionRequestEvent) {
        let mode = PropMode::REPLACE;
        self.connection
            .change_property8(mode, request.requestor, request.property, self.list, &self.text)
            .unwrap();
        let notice = SelectionNotifyEvent {
            response_type: SELECTION_NOTIFY_EVENT,
            sequence: 0,
            time: request.time,
            requestor: request.requestor,
            selection: request.selection,
            target: request.target,
            property: request.property,
        };
        self.connection.send_event(false, request.requestor, EventMask::NO_EVENT, notice).unwrap();
        self.connection.sync().unwrap();
    }

    fn next(&self, fault: &str) -> Event {
        let begin = Instant::now();
        loop {
            if let Some(event) = self.connection.poll_for_event().unwrap() {
                return event;
            }
            assert!(begin.elapsed() < crate::hand::patience(), "the window {fault}");
            std::thread::sleep(Duration::from_millis(10));
        }
    }
}
