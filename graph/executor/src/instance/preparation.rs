//! Plans prepared off the caller's thread: shader modules, layouts and pipelines, which take most of the time, are made
//! into the cache that an executor and those beside it share.
//!
//! Limits: the cache is one. Whoever sets a plan while another is prepared waits for it; recording needs no cache.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, Mutex, PoisonError};

use super::instantiate::Instantiated;
use super::requirements;
use crate::binding::draw::{DrawSource, Host, Stated};
use crate::measure::statistics::Statistics;
use crate::objects::creation::{Caught, Creation, lost, reject};
use crate::objects::shared::Objects;
use umbragraph_compiler::Plan;
use umbragraph_pipeline::Error;
use umbragraph_pipeline::diagnostic::Diagnostics;
use umbragraph_pipeline::draw::HostInterface;

/// Prepares plans for an executor, on any thread ([`Executor::preparer`](crate::Executor::preparer)).
#[derive(Clone)]
pub struct PlanPreparer {
    pub(crate) device: wgpu::Device,
    /// The cache of shader modules, layouts, pipelines and samplers that executors share.
    pub(crate) objects: Arc<Mutex<Objects>>,
    /// The mesh layouts that the executor's draw sources have declared, by geometry contract.
    pub(crate) stated: Arc<Stated>,
}

/// A plan whose pipelines exist on the device, for [`Executor::set_prepared_plan`](crate::Executor::set_prepared_plan).
pub struct PreparedPlan {
    pub(crate) plan: Arc<Plan>,
    pub(crate) late: Caught,
    pub(crate) statistics: Statistics,
    pub(crate) stated: Stated,
}

impl PreparedPlan {
    /// The counts of the device objects that the preparation created.
    pub fn statistics(&self) -> Statistics {
        self.statistics
    }
}

impl PlanPreparer {
    /// Creates the shader modules, layouts, pipelines and samplers of a plan in the cache that the executor shares. Its
    /// textures and buffers are created only as a check, and dropped. Without a draw source, the mesh layouts are those
    /// that the executor's draw sources declared.
    ///
    /// # Errors
    /// As of [`Executor::new`](crate::Executor::new).
    pub fn prepare(&self, plan: Arc<Plan>, source: Option<&dyn DrawSource>) -> Result<PreparedPlan, Error> {
        let mut statistics = Statistics::default();
        let (made, late) = self.instantiate(&mut statistics, plan.clone(), source, None)?;
        Ok(PreparedPlan { plan, late, statistics, stated: made.stated })
    }

    /// Checks a plan against the device and the host's mesh layouts, and instantiates it.
    pub(crate) fn instantiate(
        &self,
        statistics: &mut Statistics,
        plan: Arc<Plan>,
        source: Option<&dyn DrawSource>,
        before: Option<&Instantiated>,
    ) -> Result<(Instantiated, Caught), Error> {
        let sources = plan.pipeline.sources.clone();
        let made = self.try_instantiate(statistics, plan, source, before);
        made.map_err(|found| Error::new(found, &sources))
    }

    fn try_instantiate(
        &self,
        statistics: &mut Statistics,
        plan: Arc<Plan>,
        source: Option<&dyn DrawSource>,
        before: Option<&Instantiated>,
    ) -> Result<(Instantiated, Caught), Diagnostics> {
        let device = &self.device;
        let host = Host { source, stated: &self.stated };
        let mut diagnostics = requirements::check_source(&plan, device, host);
        diagnostics.extend(requirements::check_device(&plan, device));
        diagnostics.extend(lost(device));
        reject(diagnostics)?;
        let geometries: BTreeSet<&str> =
            requirements::scenes(&plan).map(|(_, scene)| scene.geometry.as_str()).collect();
        let interfaces = geometries
            .into_iter()
            .filter_map(|geometry| Some((geometry.to_owned(), host.interface(&plan, geometry)?.clone())));
        let interfaces: BTreeMap<String, HostInterface> = interfaces.collect();
        let mut stated = Stated::clone(&self.stated);
        let new = interfaces.iter().filter(|(geometry, _)| host.stated(geometry).is_some());
        stated.extend(new.map(|(geometry, interface)| (geometry.clone(), interface.clone())));
        let mut objects = self.objects.lock().unwrap_or_else(PoisonError::into_inner);
        objects.begin();
        let mut creation = Creation::new(device, statistics);
        let limits = device.limits();
        let instantiated =
            Instantiated::new(&mut creation, &limits, &mut objects, plan, (interfaces, stated), before)?;
        let mut caught = creation.finish();
        reject(caught.known())?;
        objects.commit();
        Ok((instantiated, caught))
    }
}
