//! Parts of a run for several machines.
//!
//! Loading configurations finds the shaders that pipelines reach. It takes as long as proving the small ones. So
//! shards share pipelines before templates: a pipeline (for a group of profiles) belongs to one shard, which loads it
//! alone, unless it costs more than an equal part of all. Shards that share a pipeline share its templates, the largest
//! first; a template too large for one shard is shared by its profiles. A template for a profile is whole in one shard,
//! so the reports of shards add up.
//!
//! Everything follows from the documents: each shard finds the same shares. Costs are estimates, from the passes and
//! the configurations of six pipelines. Template text that is dead in templates of different shards is not reported.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};
use umbragraph::low_level::pipeline::{AxisProduct, ReachedProgram};

/// One of several parts of the work with about equal cost.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Shard {
    /// The number of the shard, from 1.
    pub(crate) index: u32,
    pub(crate) of: u32,
}

/// The numbers of the shards that share a piece of work, each with its part of the cost.
type Shares = BTreeMap<u32, u128>;

/// The indices of the profiles for which a shard validates a template, by template.
pub(crate) type Owned<'p> = BTreeMap<&'p str, Vec<usize>>;

/// The maximum number of shards.
const MAX_SHARDS: u32 = 10_000;

impl Shard {
    /// Parses text such as `3/8`: the shard's number and the number of shards.
    ///
    /// # Errors
    /// Text of another form, or a number outside of 1 to the number of shards.
    pub(crate) fn parse(text: &str) -> Result<Self, String> {
        let form = || format!("\"{text}\" is no shard; the third of eight is written 3/8");
        let (index, of) = text.split_once('/').ok_or_else(form)?;
        let (index, of): (u32, u32) = (index.parse().map_err(|_| form())?, of.parse().map_err(|_| form())?);
        match (index, of) {
            (_, 0) => Err("there is no shard of 0; the only one of all is 1/1".to_owned()),
            (_, _) if of > MAX_SHARDS => {
                Err(format!("{of} shards are too many; there are up to {MAX_SHARDS}"))
            }
            (0, _) => Err(format!("shards count from 1: the first is 1/{of}")),
            (index, of) if index > of => {
                Err(format!("there is no shard {index} of {of}; the last is {of}/{of}"))
            }
            (index, of) => Ok(Self { index, of }),
        }
    }

    /// Distributes pieces of work with the given costs over all shards. Returns the shares of each piece, or `None` for
    /// a piece in which this shard has no share. A piece larger than an equal share of the total is cut. The largest
    /// goes first, to the shard with the least work.
    pub(crate) fn pieces(self, costs: &[u128]) -> Vec<Option<Shares>> {
        let equal = costs.iter().sum::<u128>().div_ceil(u128::from(self.of)).max(1);
        let cut = |(at, cost): (usize, u128)| {
            let count = cost.div_ceil(equal).max(1);
            (0..count).map(move |_| (cost / count, at))
        };
        let mut pieces: Vec<(u128, usize)> = costs.iter().copied().enumerate().flat_map(cut).collect();
        pieces.sort_by(|a, b| b.0.cmp(&a.0).then(a.1.cmp(&b.1)));
        let mut load: BTreeSet<(u128, u32)> = (1..=self.of).map(|shard| (0, shard)).collect();
        let mut shares: Vec<Shares> = vec![Shares::new(); costs.len()];
        for (cost, at) in pieces {
            let Some((least, shard)) = load.pop_first() else { continue };
            load.insert((least + cost, shard));
            *shares[at].entry(shard).or_default() += cost;
        }
        let own = |shares: Shares| shares.contains_key(&self.index).then_some(shares);
        shares.into_iter().map(own).collect()
    }

    /// Returns the templates of a pipeline that this shard validates, with the indices of the profiles.
    pub(crate) fn owned<'p>(
        self,
        shares: &Shares,
        programs: &'p [ReachedProgram],
        profiles: usize,
    ) -> Owned<'p> {
        let mut weights: BTreeMap<&str, u128> = BTreeMap::new();
        for program in programs {
            let weight: u128 = program.products.iter().map(weight).sum();
            *weights.entry(&program.template).or_default() += weight;
        }
        let (all, total) = (shares.values().sum::<u128>(), weights.values().sum::<u128>());
        let largest = shares.values().copied().max().unwrap_or(0);
        let mut items: Vec<(u128, &str, Vec<usize>)> = Vec::new();
        for (template, weight) in weights {
            let cost = weight * all / total.max(1);
            let parts = (cost / largest.max(1)).clamp(1, profiles.max(1) as u128) as usize;
            for part in 0..parts {
                let own = (0..profiles).skip(part).step_by(parts).collect();
                items.push((cost / parts as u128, template, own));
            }
        }
        items.sort_by(|a, b| b.0.cmp(&a.0).then(a.1.cmp(b.1)).then(a.2.cmp(&b.2)));
        let mut left: Vec<(u32, i128)> = shares
            .iter()
            .map(|(shard, share)| (*shard, i128::try_from(*share).unwrap_or(i128::MAX)))
            .collect();
        let mut owned = Owned::new();
        for (cost, template, own) in items {
            // The one with the most left; the first of equals.
            let most = left.iter().map(|(_, left)| *left).max();
            let Some((shard, left)) = left.iter_mut().find(|(_, left)| Some(*left) == most) else { continue };
            *left = left.saturating_sub(i128::try_from(cost).unwrap_or(i128::MAX));
            if *shard == self.index {
                owned.entry(template).or_default().extend(own);
            }
        }
        owned
    }
}

/// Returns a rough, unitless estimate of the cost of loading configurations and validating their reachable variants.
pub(crate) fn cost(configurations: usize, passes: usize) -> u128 {
    let states = (configurations.max(1) * passes.max(1)) as u128;
    states * states.isqrt()
}

/// Returns the relative cost of a product of axis values within a pipeline. Declarations repeat, so the cost grows
/// slower than the number of combinations.
fn weight(product: &AxisProduct) -> u128 {
    let combinations = product.values().fold(1_u128, |all, values| all.saturating_mul(values.len() as u128));
    let bits = u128::from(u128::BITS - combinations.leading_zeros());
    bits * bits
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_whole_and_about_equal() {
        for costs in [&[7, 1, 900, 30, 30, 1][..], &[1, 1, 1], &[5], &[100, 100, 90, 80, 10, 10, 10]] {
            for of in 1..12 {
                let mut taken = vec![0; costs.len()];
                let mut of_shards = vec![0; of as usize];
                for index in 1..=of {
                    for (at, shares) in (Shard { index, of }).pieces(costs).into_iter().enumerate() {
                        let own = shares.map_or(0, |shares| shares[&index]);
                        taken[at] += own;
                        of_shards[index as usize - 1] += own;
                    }
                }
                let is_cut = |(taken, cost): (&u128, &u128)| *taken <= *cost && cost - taken < u128::from(of);
                assert!(taken.iter().zip(costs).all(is_cut), "{of} shards: {taken:?}");
                let equal = costs.iter().sum::<u128>().div_ceil(u128::from(of));
                assert!(of_shards.iter().all(|own| *own <= 2 * equal), "{of} shards: {of_shards:?}");
            }
        }
    }
}
