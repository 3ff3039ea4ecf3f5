//! Detects the Linux distribution, and advises how to install a software Vulkan driver on it.
//!
//! `/etc/os-release` names the distribution (`ID`) and its ancestors (`ID_LIKE`); the first known one decides. The
//! advice always names the driver and the loader: without `libvulkan.so.1` no driver is found.

/// A family of distributions that share their packages' names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Distribution {
    Debian,
    Fedora,
    Arch,
    Alpine,
    Suse,
    Void,
    Gentoo,
    Nix,
    Unknown,
}

/// The packages of Debian and Ubuntu with a software Vulkan driver.
pub(crate) const DEBIAN_PACKAGES: [&str; 2] = ["mesa-vulkan-drivers", "libvulkan1"];

impl Distribution {
    /// Determines the distribution from the text of an `os-release` file.
    pub(crate) fn from_os_release(text: &str) -> Self {
        let value = |key: &str| {
            text.lines()
                .filter_map(|line| line.trim().split_once('='))
                .find(|(name, _)| *name == key)
                .map(|(_, value)| value.trim().trim_matches(['"', '\'']).to_lowercase())
                .unwrap_or_default()
        };
        let names = format!("{} {}", value("ID"), value("ID_LIKE"));
        names.split_whitespace().find_map(Self::from_name).unwrap_or(Self::Unknown)
    }

    fn from_name(name: &str) -> Option<Self> {
        Some(match name {
            "debian" | "ubuntu" => Self::Debian,
            "fedora" | "rhel" | "centos" => Self::Fedora,
            "arch" => Self::Arch,
            "alpine" => Self::Alpine,
            "suse" | "opensuse" | "opensuse-tumbleweed" | "opensuse-leap" | "sles" => Self::Suse,
            "void" => Self::Void,
            "gentoo" => Self::Gentoo,
            "nixos" => Self::Nix,
            _ => return None,
        })
    }

    /// Returns the command that installs a software Vulkan driver as root.
    pub(crate) fn advice(self) -> String {
        let advice = match self {
            Self::Debian => {
                return format!("apt-get update && apt-get install --yes {}", DEBIAN_PACKAGES.join(" "));
            }
            Self::Fedora => "dnf install mesa-vulkan-drivers vulkan-loader",
            Self::Arch => "pacman -S vulkan-swrast vulkan-icd-loader",
            Self::Alpine => "apk add mesa-vulkan-swrast vulkan-loader",
            Self::Suse => "zypper install libvulkan_lvp libvulkan1",
            Self::Void => "xbps-install mesa-vulkan-lavapipe vulkan-loader",
            Self::Gentoo => {
                "VIDEO_CARDS=\"lavapipe\" USE=\"vulkan\" emerge media-libs/mesa media-libs/vulkan-loader"
            }
            Self::Nix => {
                "set `hardware.graphics.enable = true;`, and have `vulkan-loader` in LD_LIBRARY_PATH"
            }
            Self::Unknown => {
                "install Mesa's software Vulkan driver (lavapipe; often called mesa-vulkan-drivers or \
                 vulkan-swrast) and the Vulkan loader (libvulkan.so.1)"
            }
        };
        advice.to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distributions_are_known_by_their_own_name() {
        for (text, expected) in [
            ("PRETTY_NAME=\"Debian GNU/Linux 12 (bookworm)\"\nID=debian\n", Distribution::Debian),
            ("NAME=\"Fedora Linux\"\nID=fedora\n", Distribution::Fedora),
            ("ID=arch\n", Distribution::Arch),
            ("ID=alpine\nVERSION_ID=3.20.0\n", Distribution::Alpine),
            ("ID=nixos\n", Distribution::Nix),
        ] {
            assert_eq!(Distribution::from_os_release(text), expected, "{text}");
        }
    }

    #[test]
    fn descendants_are_known_by_their_ancestors() {
        for (text, expected) in [
            ("ID=linuxmint\nID_LIKE=\"ubuntu debian\"\n", Distribution::Debian),
            ("ID=\"rocky\"\nID_LIKE=\"rhel centos fedora\"\n", Distribution::Fedora),
            ("ID_LIKE=arch\nID=manjaro\n", Distribution::Arch),
            ("ID=\"opensuse-tumbleweed\"\nID_LIKE=\"opensuse suse\"\n", Distribution::Suse),
        ] {
            assert_eq!(Distribution::from_os_release(text), expected, "{text}");
        }
    }

    #[test]
    fn keys_that_end_like_the_name_are_not_the_name() {
        assert_eq!(
            Distribution::from_os_release("VARIANT_ID=debian\nBUILD_ID=arch\n"),
            Distribution::Unknown
        );
        assert_eq!(Distribution::from_os_release(""), Distribution::Unknown);
    }

    #[test]
    fn every_advice_names_a_driver_and_the_loader() {
        use Distribution::*;
        for distribution in [Debian, Fedora, Arch, Alpine, Suse, Void, Gentoo, Unknown] {
            let advice = distribution.advice().to_lowercase();
            let driver = ["mesa", "swrast", "lavapipe", "lvp"].iter().any(|name| advice.contains(name));
            let loader = advice.contains("loader") || advice.contains("libvulkan1");
            assert!(driver && loader, "{distribution:?}: {advice}");
        }
    }
}
