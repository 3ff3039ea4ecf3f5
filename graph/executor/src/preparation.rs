//! Plans prepared off the caller's thread: shader modules, layouts and pipelines, which take most of the time, are made
//! into the cache that an executor and those beside it share.
//!
//! Limits: the cache is one. Whoever sets a plan while another is prepared waits for it; recording needs no cache.

use std::sync::{Arc, Mutex, PoisonError};

use super::creation::Caught;
use super::objects::Objects;
use super::{DrawSource, instantiate, reject};
use crate::compiler::Plan;
use crate::diagnostic::Diagnostics;
use umbragraph_pipeline::Error;

/// The objects that executors share.
pub(super) type Shared = Arc<Mutex<Objects>>;

/// Prepares plans for an executor, on any thread ([`Executor::preparation`](crate::Executor::preparation)).
#[derive(Clone)]
pub struct Preparation {
    pub(super) device: wgpu::Device,
    pub(super) objects: Shared,
}

/// A plan whose pipelines are made ([`Executor::adopt`](crate::Executor::adopt)).
pub struct Prepared {
    pub(super) plan: Arc<Plan>,
    pub(super) late: Caught,
}

impl Preparation {
    /// Makes what a plan needs beside its textures and buffers.
    ///
    /// # Errors
    /// As of [`Executor::new`](crate::Executor::new).
    pub fn prepare(&self, plan: Arc<Plan>, source: Option<&dyn DrawSource>) -> Result<Prepared, Error> {
        let sources = plan.pipeline.sources.clone();
        let made = self.try_prepare(plan.clone(), source);
        let late = made.map_err(|found| Error::new(found, &sources))?;
        Ok(Prepared { plan, late })
    }

    fn try_prepare(&self, plan: Arc<Plan>, source: Option<&dyn DrawSource>) -> Result<Caught, Diagnostics> {
        let mut objects = self.objects.lock().unwrap_or_else(PoisonError::into_inner);
        let mut statistics = super::Statistics::default();
        let (_, mut late) = instantiate(&self.device, &mut objects, &mut statistics, plan, source, None)?;
        reject(late.known())?;
        objects.commit();
        Ok(late)
    }
}
