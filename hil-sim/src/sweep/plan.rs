//! What a sweep tries.

use canloop::config::{Document, Problems, Reader, Section};

use super::{Axes, Axis, Case, columns};
use crate::scenario::Scenario;
use crate::wire::Chance;

/// A sweep.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Its name.
    pub name: String,
    /// The scenario's name, or its path.
    pub scenario: String,
    /// What is laid over it in every run.
    pub set: Vec<String>,
    /// What is varied.
    pub axes: Vec<Axis>,
    /// How the values are combined.
    pub method: Method,
    /// What is drawn of the results.
    pub maps: Vec<Axes>,
    /// Seeds that each combination is run with: 1, 2, and so on.
    pub seeds: u64,
    /// The plan's text: what tells it from others.
    pub text: String,
    /// Where each sample lies on each axis, for a Latin hypercube.
    strata: Vec<Vec<u32>>,
}

/// How values are combined.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// Each with each.
    Grid,
    /// So many, each axis cut into as many strata of which each is met once
    /// (McKay, Beckman and Conover, 1979).
    LatinHypercube(u64),
    /// So many, each at random.
    Random(u64),
}

/// More runs than anybody waits for.
const MOST_RUNS: u64 = 100_000_000;
/// Samples of a Latin hypercube at most.
const MOST_SAMPLES: i64 = 10_000_000;

impl Plan {
    /// Loads a plan by its path; one run of it is looked at, so that a key that
    /// does not exist is found before anything is run.
    ///
    /// # Errors
    /// Everything that is wrong with it.
    pub fn load(path: &str) -> Result<Self, Problems> {
        let document = Document::open(path, super::SHIPPED)?;
        let reader = Reader::new(&document);
        let mut plan = Self::read(&reader.root());
        plan.text = document.resolved();
        let plan = reader.finish(plan)?;
        let plan = plan.with_strata();
        Scenario::load(&plan.scenario, &plan.case(0).overrides)?;
        Ok(plan)
    }

    /// A plan from its resolved text, if it is one.
    pub fn parse(text: &str) -> Option<Self> {
        let document = Document::parse(super::results::PLAN, text).ok()?;
        let reader = Reader::new(&document);
        let mut plan = Self::read(&reader.root());
        plan.text = text.to_owned();
        reader.finish(plan).ok()
    }

    fn read(root: &Section<'_>) -> Self {
        let methods = [("grid", "grid"), ("latin-hypercube", "latin-hypercube"), ("random", "random")];
        let method = match root.choice("method", &methods, false) {
            "grid" => Method::Grid,
            method => {
                let samples = root.integer("samples", 1, MOST_SAMPLES) as u64;
                if method == "random" { Method::Random(samples) } else { Method::LatinHypercube(samples) }
            }
        };
        let varied = root.sections("vary");
        let axes: Vec<Axis> = varied.iter().map(Axis::read).collect();
        for (nth, axis) in axes.iter().enumerate() {
            if axis.key == "seed" {
                varied[nth].complain("key", "found `seed`, expected `seeds = N` beside `name`, for the seeds 1 to N");
            } else if axes[..nth].iter().any(|other| other.key == axis.key) {
                varied[nth].complain("key", &format!("found `{}` a second time, expected each key once", axis.key));
            }
        }
        if axes.is_empty() {
            root.complain("vary", "found nothing to vary, expected at least one [[vary]]");
        }
        if method == Method::Grid
            && let Some(axis) = axes.iter().find(|axis| axis.spread.count().is_none())
        {
            let found = format!("found `{}`, which may be any number, on a grid; expected values or a range", axis.key);
            root.complain("method", &found);
        }
        let columns = columns(&axes);
        let plan = Self {
            name: root.text("name"),
            maps: root.sections("map").iter().map(|map| Axes::read(map, &columns)).collect(),
            scenario: root.text("scenario"),
            set: root.texts("set"),
            axes,
            method,
            seeds: root.integer_or("seeds", 1, 1, 1_000_000) as u64,
            text: String::new(),
            strata: Vec::new(),
        };
        if plan.count().is_none_or(|count| count == 0 || count > MOST_RUNS) {
            root.complain("name", &format!("found too many runs, or none, expected 1 to {MOST_RUNS}"));
        }
        plan
    }

    /// How many runs there are; none where that is more than can be counted.
    fn count(&self) -> Option<u64> {
        let combinations = match self.method {
            Method::LatinHypercube(samples) | Method::Random(samples) => samples,
            Method::Grid => {
                self.axes.iter().try_fold(1_u64, |count, axis| count.checked_mul(axis.spread.count().unwrap_or(1)))?
            }
        };
        combinations.checked_mul(self.seeds)
    }

    /// How many runs there are.
    pub fn runs(&self) -> u64 {
        self.count().unwrap_or(0)
    }

    /// The run of that number.
    pub fn case(&self, number: u64) -> Case {
        let (combination, seed) = (number / self.seeds, number % self.seeds + 1);
        let values = self.values(combination);
        let assign = |(axis, value): (&Axis, &String)| format!("{}={value}", axis.key);
        let varied = self.axes.iter().zip(&values).map(assign);
        let overrides = self.set.iter().cloned().chain(varied).chain([format!("seed={seed}")]).collect();
        Case { number, values, seed, overrides }
    }

    fn values(&self, combination: u64) -> Vec<String> {
        match self.method {
            Method::Grid => {
                // The last axis goes fastest.
                let mut rest = combination;
                let digits = self.axes.iter().rev().map(|axis| {
                    let count = axis.spread.count().unwrap_or(1);
                    let digit = rest % count;
                    rest /= count;
                    axis.spread.nth(digit)
                });
                let mut values: Vec<String> = digits.collect();
                values.reverse();
                values
            }
            Method::Random(_) => {
                let axes = self.axes.iter().enumerate();
                axes.map(|(nth, axis)| axis.spread.quantile(share(combination, nth as u64))).collect()
            }
            Method::LatinHypercube(samples) => {
                let axes = self.axes.iter().zip(&self.strata).enumerate();
                let value = |(nth, (axis, strata)): (usize, (&Axis, &Vec<u32>))| {
                    let within = share(combination, nth as u64);
                    axis.spread.quantile((f64::from(strata[combination as usize]) + within) / samples as f64)
                };
                axes.map(value).collect()
            }
        }
    }

    fn with_strata(mut self) -> Self {
        if let Method::LatinHypercube(samples) = self.method {
            self.strata = (0..self.axes.len()).map(|axis| shuffled(samples as u32, axis as u64)).collect();
        }
        self
    }
}

/// Rows of chance that samples and strata take: none that a run has.
const SAMPLES: u64 = 1 << 40;
const STRATA: u64 = 1 << 41;

/// A number from 0 to 1 for this sample on this axis.
fn share(sample: u64, axis: u64) -> f64 {
    let mut chance = Chance::new(sample, SAMPLES + axis);
    f64::from(chance.bits()) / 4_294_967_296.0
}

/// The numbers below `count` in an order of chance (Fisher and Yates).
fn shuffled(count: u32, axis: u64) -> Vec<u32> {
    let mut chance = Chance::new(0, STRATA + axis);
    let mut order: Vec<u32> = (0..count).collect();
    for last in (1..count).rev() {
        order.swap(last as usize, chance.below(last + 1) as usize);
    }
    order
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    fn plan(text: &str) -> Plan {
        let document = Document::parse("plan.toml", text).expect("TOML");
        let reader = Reader::new(&document);
        let plan = Plan::read(&reader.root());
        reader.finish(plan).unwrap_or_else(|problems| panic!("{problems}")).with_strata()
    }

    const GRID: &str = "name = \"g\"\nscenario = \"line\"\nset = [\"duration_s=1\"]\nseeds = 2\n\
        [[vary]]\nkey = \"period_s\"\nvalues = [0.005, 0.01]\n\
        [[vary]]\nkey = \"robot.load.mass_kg\"\nfrom = 0\nto = 100\ncount = 3\n";

    #[test]
    fn a_grid_has_each_value_with_each_and_each_seed() {
        let plan = plan(GRID);
        assert_eq!(plan.runs(), 12);
        let overrides = plan.case(7).overrides;
        assert_eq!(overrides, ["duration_s=1", "period_s=0.01", "robot.load.mass_kg=0.0", "seed=2"]);
        let all: BTreeSet<Vec<String>> = (0..12).map(|number| plan.case(number).overrides).collect();
        assert_eq!(all.len(), 12);
    }

    #[test]
    fn values_of_any_kind_are_laid_over_the_scenario_as_they_stand_in_the_plan() {
        let plan = plan(
            "name = \"k\"\nscenario = \"line\"\n[[vary]]\nkey = \"a\"\n\
             values = [true, \"two\", 3, 4.5, { law = \"dac\", kp = 1 }, [5, 6]]\n",
        );
        let assigned: Vec<String> = (0..6).map(|number| plan.case(number).overrides[0].clone()).collect();
        let expected = ["a=true", "a=\"two\"", "a=3", "a=4.5", "a={ kp = 1, law = \"dac\" }", "a=[5, 6]"];
        assert_eq!(assigned, expected);
    }

    #[test]
    fn a_value_that_no_key_takes_is_refused_wherever_it_stands() {
        for value in ["1979-05-27", "inf", "[1, nan]", "{ a = [1979-05-27] }"] {
            let text = format!("name = \"k\"\nscenario = \"line\"\n[[vary]]\nkey = \"a\"\nvalues = [{value}, 1]\n");
            let document = Document::parse("plan.toml", text).expect("TOML");
            let reader = Reader::new(&document);
            let plan = Plan::read(&reader.root());
            assert!(reader.finish(plan).is_err(), "{value}");
        }
    }

    #[test]
    fn a_latin_hypercube_meets_each_stratum_of_each_axis_once() {
        let plan = plan(
            "name = \"l\"\nscenario = \"line\"\nmethod = \"latin-hypercube\"\nsamples = 50\n\
             [[vary]]\nkey = \"a\"\nuniform = [0, 50]\n[[vary]]\nkey = \"b\"\nuniform = [0, 50]\n",
        );
        for axis in 0..2 {
            let strata = (0..50).map(|number| plan.case(number).values[axis].parse::<f64>().expect("a number") as u32);
            assert_eq!(strata.collect::<BTreeSet<_>>(), (0..50).collect(), "axis {axis}");
        }
        assert_eq!(plan.case(17), plan.case(17));
        assert_ne!(plan.case(17).values[0], plan.case(17).values[1]);
    }

    #[test]
    fn random_samples_keep_to_their_distribution() {
        let plan = plan(
            "name = \"r\"\nscenario = \"line\"\nmethod = \"random\"\nsamples = 20000\n\
             [[vary]]\nkey = \"a\"\nnormal = [10, 2]\n",
        );
        let values: Vec<f64> =
            (0..20_000).map(|number| plan.case(number).values[0].parse().expect("a number")).collect();
        let mean = values.iter().sum::<f64>() / 20_000.0;
        let variance = values.iter().map(|value| (value - mean) * (value - mean)).sum::<f64>() / 20_000.0;
        assert!((mean - 10.0).abs() < 0.05 && (variance.sqrt() - 2.0).abs() < 0.05, "{mean} {}", variance.sqrt());
    }
}
