//! Violations: what can be wrong with a plan.

use serde::Serialize;

/// The rule that a plan violates.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum ViolationKind {
    /// A pass is planned twice, or both planned and culled.
    PassTwice,
    /// A pass of the pipeline is neither planned nor culled.
    PassMissing,
    /// The plan has a pass that the pipeline does not have.
    PassUnknown,
    /// A culled pass is needed: a planned pass or an output depends on its result, or it has a side effect.
    CulledButNeeded,
    /// A planned pass leads to no output.
    KeptWithoutReason,
    /// The stated reason for keeping a pass does not hold.
    WrongReason,
    /// The stated reason for culling a pass does not hold.
    WrongCullReason,
    /// A pass runs before a pass that it declares to follow with `after`.
    AfterViolated,
    /// A pass reads a subresource range, or a part of one, that no pass has written.
    UninitialisedRead,
    /// A pass reads another version of a resource than it names.
    WrongVersion,
    /// A pass that reads the newest version runs before the pass that writes this version.
    ReadTooEarly,
    /// The order of two writers in the plan follows from no declaration in the pipeline document.
    WritersUnordered,
    /// A pass needs contents that an earlier pass discarded instead of storing.
    ContentsDropped,
    /// The contents of a resource that outlives the frame are discarded.
    OutputDropped,
    /// The planned attachments differ from those that the pass declares.
    AttachmentsDiffer,
    /// The load operation of an attachment differs from the declared one.
    LoadDiffers,
    /// The plan stores an attachment that the pass declares as discarded.
    StoreDiffers,
    /// An attachment is marked as transient, although its contents enter or leave the pass.
    TransientAttachmentLeaves,
    /// Passes of one group cannot be merged into one render pass.
    GroupBroken,
    /// A resource that a planned pass uses is not planned.
    ResourceMissing,
    /// A planned resource is used by no planned pass.
    ResourceUnused,
    /// The stated first or last access of a resource is wrong.
    SpanWrong,
    /// The physical location of a resource (texture, buffer, import or blackboard) does not fit its kind or lifetime.
    PlaceWrong,
    /// A resource refers to a physical texture or buffer that does not exist.
    PlaceMissing,
    /// Two resources with overlapping lifetimes share memory.
    Overlap,
    /// A resource shares memory with another, although it outlives the frame or sharing is switched off.
    SharedThoughLasting,
    /// A resource and its physical texture or buffer differ in format, size or dimension.
    CompatibilityMismatch,
    /// A physical texture or buffer lacks a usage that a pass needs.
    UsageMissing,
    /// An imported texture is planned with a format, size or usage that the host's texture does not have.
    ImportMisused,
    /// A pass uses a mip level, layer or byte range that the resource does not have.
    SubresourceMissing,
    /// A compatibility class has more physical resources than resources alive at once.
    NotMinimal,
    /// A physical texture or buffer holds no resource.
    PhysicalUnused,
    /// A history is not planned, has an unsuitable initial value, or its physical resources are wrong in number, differ
    /// in descriptor, or are not distinct.
    HistoryWrong,
    /// A stated sum of bytes is wrong.
    BytesWrong,
    /// A compute pass without an indirect dispatch has no workgroup counts, another pass has some, or the counts exceed
    /// the limits.
    WorkgroupsWrong,
    /// The name, kind or lifetime of a pass or resource in the plan differs from the pipeline.
    NameWrong,
    /// The toggles of the plan, the toggle or passthrough of a pass, or the conditional mark of a resource differ from
    /// the pipeline.
    ToggleWrong,
    /// A reader of a resource with a passthrough does not use the fallback in exactly the frames in which the writer is
    /// off.
    PassthroughMissing,
    /// A fallback differs from the replaced resource in dimension, layers or samples, or is a buffer that is too small.
    PassthroughMisfit,
    /// A transfer copies other mip levels, layers, aspects, texels or bytes than declared, or the accesses of its pass
    /// differ from its source and destination.
    CopyWrong,
    /// A resource shares memory, although a toggle can switch off its first writer.
    SharedThoughConditional,
}

/// One violation of a rule in a plan.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct Violation {
    /// The violated rule.
    pub kind: ViolationKind,
    /// The message, with the names of passes and resources.
    pub message: String,
}

impl std::fmt::Display for Violation {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.write_str(&self.message)
    }
}

/// The violations found so far.
pub(crate) struct Violations(pub(crate) Vec<Violation>);

impl Violations {
    pub(crate) fn add(&mut self, kind: ViolationKind, message: String) {
        self.0.push(Violation { kind, message });
    }
}
