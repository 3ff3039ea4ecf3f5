//! Error scopes around work on the device.
//!
//! A document can ask for what a device does not have, such as more memory than there is. wgpu's own handler of such an
//! error ends the process. Within a scope the error becomes a diagnostic, and the window goes on.

use umbragraph::diagnostic::{Diagnostic, Place, codes};
use umbragraph::wgpu;

/// Runs `work` inside error scopes of the device; `what` names the work in the diagnostic.
///
/// # Errors
/// The first error that the device raised during the work.
pub(crate) fn guarded<T>(
    device: &wgpu::Device,
    what: &str,
    work: impl FnOnce() -> T,
) -> Result<T, Diagnostic> {
    let filters =
        [wgpu::ErrorFilter::Internal, wgpu::ErrorFilter::OutOfMemory, wgpu::ErrorFilter::Validation];
    let scopes = filters.map(|filter| device.push_error_scope(filter));
    let done = work();
    let mut first = None;
    // The scope that was opened last is closed first, and all of them are closed.
    for scope in scopes.into_iter().rev() {
        first = first.or(pollster::block_on(scope.pop()));
    }
    first.map_or(Ok(done), |error| {
        let message = format!("the device rejected {what}: {error}");
        Err(Diagnostic::error(codes::DEVICE, Place::Nowhere, message)
            .help("make it smaller, or choose another format; the frame before stays until it can be drawn"))
    })
}
