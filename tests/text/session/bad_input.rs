//! Files as they should not be: each is a diagnostic, and mended is forgotten.

use std::path::Path;

use umbragraph::diagnostic::Diagnostic;
use umbragraph::low_level::compose::Roots;
use umbragraph::low_level::session::{Session, Storage};
use umbragraph::low_level::source::{FileId, Sources};
use umbragraph::{DiskStorage, with_templates};
use umbragraph_test_support::scratch::ScratchFolder;

use crate::session::{PART, WHOLE, plan, session, two_files};

#[test]
fn text_over_a_path_without_a_file_is_that_file() {
    let mut session = session(&[("whole.json", WHOLE)]);
    assert!(plan(&mut session, "whole.json").contains("UG0001"));
    session.overlay("./part.json", PART.as_bytes());
    assert_eq!(plan(&mut session, "whole.json"), "");
    session.close("part.json");
    assert!(plan(&mut session, "whole.json").contains("part.json"));
}

#[test]
fn overlay_that_is_not_utf8_is_a_diagnostic_at_the_byte() {
    let mut session = two_files();
    session.overlay("part.json", b"{ \"description\": \"\xff\" }".as_slice());
    let text = plan(&mut session, "whole.json");
    assert!(text.contains("UG0002") && text.contains("not UTF-8"), "{text}");
    session.overlay("whole.json", b"{ \xff }".as_slice());
    let text = plan(&mut session, "whole.json");
    assert!(text.contains("UG0002") && text.contains("whole.json:1:3"), "{text}");
    session.close("whole.json");
    session.close("part.json");
    assert_eq!(plan(&mut session, "whole.json"), "");
}

#[test]
fn include_that_becomes_a_cycle_by_an_edit_is_a_diagnostic() {
    let mut session = two_files();
    assert_eq!(plan(&mut session, "whole.json"), "");
    session.overlay("part.json", r#"{ "include": ["whole.json"] }"#.as_bytes());
    let text = plan(&mut session, "whole.json");
    assert!(text.contains("UG0007") && text.contains("leads back to itself"), "{text}");
    session.close("part.json");
    assert_eq!(plan(&mut session, "whole.json"), "");
}

#[test]
fn line_of_ten_megabytes_is_shown_in_part() {
    let mut session = two_files();
    let long = format!("{{ \"description\": \"{}\", \"wrong\": 1 }}", "x".repeat(10 << 20));
    session.overlay("part.json", long.into_bytes());
    let text = plan(&mut session, "whole.json");
    assert!(text.contains("part.json:1:") && text.contains("wrong"), "{text:.400}");
    assert!(text.len() < 10_000, "{} bytes", text.len());
}

#[test]
fn texts_over_two_paths_to_one_file_are_a_warning() {
    let mut session = two_files();
    session.overlay("./part.json", PART.as_bytes());
    session.overlay("part.json", PART.as_bytes());
    let text = plan(&mut session, "whole.json");
    assert!(text.contains("UG0011") && text.contains("\"./part.json\" and for \"part.json\""), "{text}");
}

#[cfg(unix)]
#[test]
fn one_file_by_two_paths_is_a_warning() {
    let folder = ScratchFolder::new("session-twice");
    std::fs::write(folder.join("part.json"), PART).unwrap();
    std::os::unix::fs::symlink(folder.join("part.json"), folder.join("link.json")).unwrap();
    let whole = WHOLE.replace("\"part.json\"", "\"part.json\", \"link.json\"");
    std::fs::write(folder.join("whole.json"), whole).unwrap();
    let mut session = Session::new(DiskStorage, umbragraph::registry(), with_templates([]));
    let path = folder.join("whole.json");
    let text = plan(&mut session, path.to_str().unwrap());
    assert!(text.contains("UG0011") && text.contains("are the same file"), "{text}");
}

/// A file that says something else whenever it is read.
struct Restless(usize);

impl Storage for Restless {
    fn read(&mut self, path: &Path, _: Option<&Roots>, sources: &mut Sources) -> Result<FileId, Diagnostic> {
        self.0 += 1;
        let text = match path.to_str() {
            Some("whole.json") => WHOLE.replace("\"part.json\"", "\"part.json\", \"a/b.json\""),
            // The first include would be without its parameter the second time.
            Some("a/b.json") => r#"{ "include": ["../part.json"] }"#.to_owned(),
            _ => PART.replace("side", &format!("side{}", self.0)),
        };
        Ok(sources.add(path.display().to_string(), text))
    }
}

#[test]
fn file_that_changes_between_reads_is_one_text_in_an_answer() {
    let mut session = Session::new(Restless(0), umbragraph::registry(), with_templates([]));
    let first = plan(&mut session, "whole.json");
    assert!(first.contains("side2") && !first.contains("side3"), "{first}");
    assert_eq!(plan(&mut session, "whole.json"), first);
    session.changed("part.json");
    assert!(plan(&mut session, "whole.json").contains("side4"));
}
