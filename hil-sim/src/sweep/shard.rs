//! A part of a sweep, for one of several machines.

/// The i-th of n disjoint parts: each n-th case, so that all parts take alike
/// long.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// Which, from 1.
    pub index: u64,
    /// Of how many.
    pub of: u64,
}

/// Variables by which engines that run parts tell which one it is and of how
/// many, and the number that they begin with.
const ENGINES: [(&str, &str, u64); 4] = [
    // Slurm's job arrays begin where the user says: at the least, which it tells.
    ("SLURM_ARRAY_TASK_ID", "SLURM_ARRAY_TASK_COUNT", u64::MAX),
    // Kubernetes' indexed jobs; the count is the manifest's to pass on.
    ("JOB_COMPLETION_INDEX", "JOB_COMPLETIONS", 0),
    // GitLab.
    ("CI_NODE_INDEX", "CI_NODE_TOTAL", 1),
    // CircleCI.
    ("CIRCLE_NODE_INDEX", "CIRCLE_NODE_TOTAL", 0),
];
/// Where Slurm tells the least index of an array.
const SLURM_LEAST: &str = "SLURM_ARRAY_TASK_MIN";

impl Shard {
    /// All of it.
    pub const WHOLE: Self = Self { index: 1, of: 1 };

    /// Reads `I/N`.
    ///
    /// # Errors
    /// Another form, or I that is not from 1 to N.
    pub fn parse(text: &str) -> Result<Self, String> {
        let expected = "expected I/N, I from 1 to N";
        let numbers = text.split_once('/').and_then(|(index, of)| Some((index.parse().ok()?, of.parse().ok()?)));
        match numbers {
            Some((index, of)) if of >= 1 && (1..=of).contains(&index) => Ok(Self { index, of }),
            _ => Err(format!("found {text:?}, {expected}")),
        }
    }

    /// What an engine says in its environment variables, if there is one.
    ///
    /// # Errors
    /// It says only half, or what cannot be.
    pub fn of_engine(variable: impl Fn(&str) -> Option<String>) -> Result<Option<Self>, String> {
        let number = |name: &str| {
            let Some(text) = variable(name).filter(|text| !text.is_empty()) else { return Ok(None) };
            let parsed: Result<u64, _> = text.parse();
            parsed.map(Some).map_err(|_| format!("found {name}={text}, expected a whole number"))
        };
        for (index_name, count_name, first) in ENGINES {
            let (Some(index), count) = (number(index_name)?, number(count_name)?) else { continue };
            let first = if first == u64::MAX { number(SLURM_LEAST)?.unwrap_or(1) } else { first };
            let Some(of) = count else {
                return Err(format!("found {index_name}={index} without {count_name}, which says how many there are"));
            };
            let nth = index.checked_sub(first).map(|nth| nth + 1).filter(|nth| (1..=of).contains(nth));
            let index =
                nth.ok_or_else(|| format!("found {index_name}={index} of {count_name}={of}, which cannot be"))?;
            return Ok(Some(Self { index, of }));
        }
        Ok(None)
    }

    /// How many of `cases` cases are its own.
    pub const fn count(&self, cases: u64) -> u64 {
        (cases + self.of - self.index) / self.of
    }

    /// The number of its `nth` case, from 0.
    pub const fn case(&self, nth: u64) -> u64 {
        nth * self.of + self.index - 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_are_disjoint_and_together_the_whole() {
        for (cases, of) in [(0, 3), (1, 3), (10, 3), (12, 4), (5, 8)] {
            let mut all: Vec<u64> = (1..=of)
                .map(|index| Shard { index, of })
                .flat_map(|shard| (0..shard.count(cases)).map(move |nth| shard.case(nth)))
                .collect();
            all.sort_unstable();
            assert_eq!(all, (0..cases).collect::<Vec<_>>(), "{cases} in {of}");
        }
    }

    #[test]
    fn engines_are_understood() {
        let engine = |variables: &[(&str, &str)]| {
            Shard::of_engine(|name| {
                variables.iter().find(|(known, _)| *known == name).map(|(_, value)| (*value).to_owned())
            })
        };
        let shard = |index, of| Ok(Some(Shard { index, of }));
        assert_eq!(engine(&[]), Ok(None));
        let slurm = [("SLURM_ARRAY_TASK_ID", "7"), ("SLURM_ARRAY_TASK_COUNT", "4"), ("SLURM_ARRAY_TASK_MIN", "5")];
        assert_eq!(engine(&slurm), shard(3, 4));
        assert_eq!(engine(&[("JOB_COMPLETION_INDEX", "0"), ("JOB_COMPLETIONS", "8")]), shard(1, 8));
        assert_eq!(engine(&[("CI_NODE_INDEX", "2"), ("CI_NODE_TOTAL", "2")]), shard(2, 2));
        assert!(engine(&[("JOB_COMPLETION_INDEX", "3")]).expect_err("of how many?").contains("JOB_COMPLETIONS"));
        assert!(engine(&[("CI_NODE_INDEX", "0"), ("CI_NODE_TOTAL", "2")]).is_err());
        assert!(engine(&[("CI_NODE_INDEX", "x"), ("CI_NODE_TOTAL", "2")]).is_err());
    }

    #[test]
    fn a_part_that_cannot_be_is_refused() {
        assert_eq!(Shard::parse("2/5"), Ok(Shard { index: 2, of: 5 }));
        for text in ["0/5", "6/5", "1/0", "1", "a/b", "-1/2", ""] {
            assert!(Shard::parse(text).expect_err(text).contains("expected I/N"), "{text}");
        }
    }
}
