//! Makes sure that a graphics adapter is available.
//!
//! macOS has Metal and Windows has DirectX 12. Linux needs a Vulkan driver. If [`crate::driver_search`] finds none,
//! Mesa's software driver is installed with apt, on Debian or a descendant, as root or with a sudo that asks for no
//! password. Elsewhere, or if the installation fails, a message on standard error says what to do.
//!
//! The result is a hint, not a verdict: a search by file names can be wrong. A step that needs an adapter reports a
//! missing one itself.

use std::path::Path;

use crate::distribution::{DEBIAN_PACKAGES, Distribution};
use crate::driver_search::{Machine, SearchResult};
use crate::process;

/// Returns `true` if an adapter is available, after trying to install one.
pub(crate) fn ensure() -> bool {
    match std::env::consts::OS {
        "linux" => ensure_on_linux(),
        "macos" | "windows" => true,
        other => {
            eprintln!("note: whether {other} has a graphics driver was not looked up");
            true
        }
    }
}

/// Calls [`ensure`] for a command that can continue without an adapter, and prints a note on failure.
pub(crate) fn ensure_if_possible() {
    if !ensure() {
        eprintln!(
            "going on all the same: the search for a driver goes by file names and may have missed one"
        );
    }
}

fn ensure_on_linux() -> bool {
    let result = search();
    if let SearchResult::Driver(manifest) = &result {
        println!("Vulkan driver: {}", manifest.display());
        return true;
    }
    eprintln!("{}", explain(&result));
    if let SearchResult::Restricted { .. } = result {
        return false;
    }
    let distribution = this_distribution();
    let installed = installation_rights(distribution)
        .map_err(|reason| format!("it cannot be installed from here: {reason}"))
        .and_then(|prefix| install(&prefix, &DEBIAN_PACKAGES));
    if let Err(reason) = installed {
        eprintln!("{reason}\nto have a software driver, as root: {}", distribution.advice());
        return false;
    }
    match search() {
        SearchResult::Driver(manifest) => {
            println!("Vulkan driver, now installed: {}", manifest.display());
            true
        }
        other => {
            eprintln!("the packages were installed, and still: {}", explain(&other));
            false
        }
    }
}

fn search() -> SearchResult {
    let variable = |name: &str| std::env::var_os(name);
    Machine { root: Path::new("/"), variable: &variable }.search()
}

fn this_distribution() -> Distribution {
    let text = ["/etc/os-release", "/usr/lib/os-release"]
        .iter()
        .find_map(|path| std::fs::read_to_string(path).ok())
        .unwrap_or_default();
    Distribution::from_os_release(&text)
}

fn explain(result: &SearchResult) -> String {
    match result {
        SearchResult::Driver(manifest) => format!("Vulkan driver: {}", manifest.display()),
        SearchResult::Restricted { variable, value } => {
            format!(
                "{variable} is set to `{value}`, which names no Vulkan driver that can work here; unset it or correct it"
            )
        }
        SearchResult::NoLoader => {
            "there is a Vulkan driver, but not the Vulkan loader, libvulkan.so.1".to_owned()
        }
        SearchResult::NoDriver(passed_over) => {
            let details: String = passed_over.iter().map(|line| format!("\n  {line}")).collect();
            format!("there is no Vulkan driver that can work here{details}")
        }
    }
}

/// Returns the command prefix that runs `apt-get` as root, or the reason why it cannot run.
fn installation_rights(distribution: Distribution) -> Result<Vec<&'static str>, String> {
    let user = process::program("id").arg("--user").output().map(|output| output.stdout);
    let root = user.is_ok_and(|output| String::from_utf8_lossy(&output).trim() == "0");
    rights(
        distribution == Distribution::Debian,
        process::succeeds("apt-get", &["--version"]),
        root,
        // With -n sudo fails rather than ask for a password.
        || process::succeeds("sudo", &["-n", "true"]),
    )
}

fn rights(debian: bool, apt: bool, root: bool, sudo: impl Fn() -> bool) -> Result<Vec<&'static str>, String> {
    match (debian, apt) {
        (false, _) => Err("only Debian's and Ubuntu's packages are installed by this command".to_owned()),
        (true, false) => Err("there is no apt-get".to_owned()),
        (true, true) if root => Ok(Vec::new()),
        (true, true) if sudo() => Ok(vec!["sudo", "-n"]),
        (true, true) => Err("this user is not root, and sudo is missing or asks for a password".to_owned()),
    }
}

/// Installs packages of Debian or Ubuntu, if the system and the user's rights allow it.
pub(crate) fn install_packages(packages: &[&str]) -> Result<(), String> {
    install(&installation_rights(this_distribution())?, packages)
}

fn install(prefix: &[&str], packages: &[&str]) -> Result<(), String> {
    println!("installing {}", packages.join(" and "));
    // A list that is out of date, or one mirror that is down, may still be enough to install from.
    let update = apt(prefix, &["update"]);
    if let Err(reason) = &update {
        eprintln!("{reason}; going on with the package lists at hand");
    }
    let mut arguments = vec!["install", "--yes", "--no-install-recommends"];
    arguments.extend(packages);
    apt(prefix, &arguments).map_err(|reason| match update {
        Ok(()) => reason,
        Err(update) => format!("{reason}, after {update}; is the network reachable?"),
    })
}

fn apt(prefix: &[&str], arguments: &[&str]) -> Result<(), String> {
    let words = apt_command(prefix, arguments);
    let shown = format!("`{}`", words.join(" "));
    let Some((name, rest)) = words.split_first() else {
        return Err("there is nothing to run".to_owned());
    };
    process::run(process::program(name).args(rest), &shown)
}

/// Returns an `apt-get` command line. The variable is set through `env`, since sudo does not pass variables on.
fn apt_command<'a>(prefix: &[&'a str], arguments: &[&'a str]) -> Vec<&'a str> {
    let mut words = prefix.to_vec();
    words.extend(["env", "DEBIAN_FRONTEND=noninteractive", "apt-get"]);
    words.extend(arguments);
    words
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn root_needs_no_sudo() {
        assert_eq!(rights(true, true, true, || panic!("sudo was asked")), Ok(Vec::new()));
    }

    #[test]
    fn another_user_needs_a_sudo_that_asks_nothing() {
        assert_eq!(rights(true, true, false, || true), Ok(vec!["sudo", "-n"]));
        assert!(rights(true, true, false, || false).unwrap_err().contains("not root"));
    }

    #[test]
    fn nothing_is_installed_without_debian_and_apt() {
        assert!(rights(false, true, true, || true).is_err());
        assert!(rights(true, false, true, || true).unwrap_err().contains("apt-get"));
    }

    #[test]
    fn apt_never_asks() {
        let words = apt_command(&["sudo", "-n"], &["install", "--yes", "some"]).join(" ");
        assert_eq!(words, "sudo -n env DEBIAN_FRONTEND=noninteractive apt-get install --yes some");
    }

    #[test]
    fn a_restriction_is_explained_with_its_variable_and_value() {
        let result = SearchResult::Restricted { variable: "VK_DRIVER_FILES", value: "/none".to_owned() };
        let words = explain(&result);
        assert!(words.contains("VK_DRIVER_FILES") && words.contains("`/none`"), "{words}");
    }
}
