//! The shaders of `pipelines/awsm.json` as Chrome's compiler takes them, where it is installed: `tint`, on the search
//! path.
//!
//! Asked are the distinct modules of the pipelines that the table of reference pictures draws. `umbragraph permutations
//! pipelines/awsm.json --also 'tint --format wgsl -o /dev/null {}'` asks about every variant there is.

use std::collections::BTreeMap;
use std::process::{Command, Stdio};

use crate::common::pictures;
use umbragraph_test_support::property;
use umbragraph_test_support::scratch::ScratchFolder;
use umbragraph_test_support::skip;

#[test]
fn chrome_s_compiler_takes_every_module_of_the_pictures() {
    let found = Command::new("tint").arg("--help").stdout(Stdio::null()).stderr(Stdio::null()).status();
    if found.is_err() {
        skip::skipped("tint is not installed");
        return;
    }
    let mut modules = BTreeMap::new();
    for case in property::part(pictures::of_variants("awsm"), 4) {
        let outcome = case.check(&[]);
        let programs = &outcome.plan().pipeline.programs;
        for module in programs.iter().flat_map(|program| &program.variants).map(|variant| &variant.module) {
            modules.entry(module.hash).or_insert_with(|| (case.name.clone(), module.clone()));
        }
    }
    let folder = ScratchFolder::new("second-compiler");
    let mut rejected = Vec::new();
    for (at, (case, module)) in modules.values().enumerate() {
        let path = folder.join(format!("{at}.wgsl"));
        std::fs::write(&path, module.wgsl.as_bytes()).expect("a file");
        let output = Command::new("tint")
            .args(["--format", "wgsl", "-o", "/dev/null"])
            .arg(&path)
            .output()
            .expect("a process");
        if !output.status.success() {
            let said = String::from_utf8_lossy(&output.stderr).into_owned();
            rejected.push(format!("{case}, {}: {said}", module.template));
        }
    }
    println!("{} modules", modules.len());
    assert!(modules.len() > 4, "{} modules", modules.len());
    assert!(rejected.is_empty(), "{}", rejected.join("\n"));
}
