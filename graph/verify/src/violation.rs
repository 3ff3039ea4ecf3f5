//! Violations: what can be wrong with a plan.

use serde::Serialize;

/// The kind of a violation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum ViolationKind {
    /// A pass is planned twice, or planned and culled.
    PassTwice,
    /// A pass of the pipeline is neither planned nor culled.
    PassMissing,
    /// The plan has a pass that the pipeline does not have.
    PassUnknown,
    /// A culled pass is needed.
    CulledButNeeded,
    /// A planned pass leads to no output.
    KeptWithoutReason,
    /// The stated reason for keeping a pass does not hold.
    WrongReason,
    /// The stated reason for culling a pass does not hold.
    WrongCullReason,
    /// A pass runs before one that it has to follow.
    AfterViolated,
    /// A pass reads what nothing has written.
    UninitialisedRead,
    /// A pass reads another version than it asks for.
    WrongVersion,
    /// A pass reads before the newest version is made.
    ReadTooEarly,
    /// Two writers whose order in the plan follows from nothing in the document.
    WritersUnordered,
    /// A pass needs contents that an earlier pass did not store.
    ContentsDropped,
    /// A resource that outlives the frame is not stored.
    OutputDropped,
    /// The attachments are not those that the pass declares.
    AttachmentsDiffer,
    /// A load operation is not the one that the pass declares.
    LoadDiffers,
    /// A pass declares that it discards an attachment, but the plan stores it.
    StoreDiffers,
    /// An attachment is marked as staying in its pass, but does not.
    TransientAttachmentLeaves,
    /// Passes of one group cannot be one render pass.
    GroupBroken,
    /// A resource that a planned pass uses is not planned.
    ResourceMissing,
    /// A planned resource is used by no planned pass.
    ResourceUnused,
    /// The first or last access of a resource is stated wrong.
    SpanWrong,
    /// A resource has a place that does not fit its kind or lifetime.
    PlaceWrong,
    /// A place does not exist.
    PlaceMissing,
    /// Two resources that are alive together share memory.
    Overlap,
    /// A resource that outlives the frame shares memory.
    SharedThoughLasting,
    /// A resource and its physical object differ in format, size, dimension or usages.
    CompatibilityMismatch,
    /// A texture lacks a usage that a pass needs.
    UsageMissing,
    /// An imported texture is used beyond what the host allows.
    ImportMisused,
    /// A mip or layer is used that the texture does not have.
    SubresourceMissing,
    /// There are more physical resources than are ever alive at once.
    NotMinimal,
    /// A physical resource stands for nothing.
    PhysicalUnused,
    /// The frames of a history are too few, not of one kind, or not apart from one another.
    HistoryWrong,
    /// A sum of bytes is wrong.
    BytesWrong,
    /// A compute pass has no workgroup counts, another pass has, or they are beyond the limits.
    WorkgroupsWrong,
    /// The name, kind or lifetime in the plan is not the pipeline's.
    NameWrong,
    /// The toggle or the passthrough of a pass in the plan is not what the pipeline says.
    ToggleWrong,
    /// A reader of what has a passthrough does not use its fallback, or not in those frames.
    PassthroughMissing,
    /// The fallback differs from its resource in dimension, layers or samples, or is too small a buffer.
    PassthroughMisfit,
    /// A transfer copies other mips, layers, aspects, texels or bytes than it describes, or says that it uses others.
    CopyWrong,
    /// A resource shares memory though a toggle can switch off what writes it first.
    SharedThoughConditional,
}

/// One thing that is wrong with a plan.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct Violation {
    /// The rule that is violated.
    pub kind: ViolationKind,
    /// The message, with the names of passes and resources.
    pub message: String,
}

impl std::fmt::Display for Violation {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.write_str(&self.message)
    }
}

/// The violations so far.
pub(crate) struct Violations(pub(crate) Vec<Violation>);

impl Violations {
    pub(crate) fn add(&mut self, kind: ViolationKind, message: String) {
        self.0.push(Violation { kind, message });
    }
}
