//! Versions of resources.

/// The version of a resource that a pass reads. Each pass that writes a resource makes a new version.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Version {
    /// The newest version; for a pass that also writes the resource, the version before its own write.
    Newest,
    /// The version that the named pass wrote.
    WrittenBy(String),
    /// The contents before the first write of the frame.
    Before,
}

impl From<Option<String>> for Version {
    fn from(version: Option<String>) -> Self {
        match version {
            None => Self::Newest,
            Some(version) if version == "0" => Self::Before,
            Some(pass) => Self::WrittenBy(pass),
        }
    }
}
