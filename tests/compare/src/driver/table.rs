//! The results as CSV, as a table and as the line at the end.

use nsrm_compare::Job;

use super::Missing;
use super::rounds::Measured;

/// The header of `compare.csv`.
const HEADER: &str = "job,contender,p50_us,p99_us,p9999_us";
/// The jobs of the last line.
const HEADLINES: [Job; 4] = [Job::Plan, Job::Encoder, Job::Splitter, Job::Crops];

/// What was measured.
#[derive(Debug, Clone)]
pub(crate) struct Table {
    /// Their names, in order.
    pub(crate) contenders: Vec<&'static str>,
    /// By job, then by contender.
    pub(crate) measured: Vec<Measured>,
    /// What has no times.
    pub(crate) missing: Vec<Missing>,
}

impl Table {
    /// The content of `compare.csv`.
    pub(crate) fn csv(&self) -> String {
        let mut text = format!("{HEADER}\n");
        for Measured {
            contender,
            job,
            times,
        } in &self.measured
        {
            text += &format!(
                "{job},{contender},{:.3},{:.3},{:.3}\n",
                times.p50_us, times.p99_us, times.p9999_us
            );
        }
        text
    }

    /// A row for each job and contender, as Markdown. `times ours` is its p50 divided by that of
    /// `nsrm`.
    pub(crate) fn markdown(&self) -> String {
        let mut text = String::from(
            "| job | contender | p50 µs | p99 µs | p99.99 µs | times `nsrm` |\n\
             |---|---|---:|---:|---:|---:|\n",
        );
        for job in Job::ALL {
            for contender in &self.contenders {
                text += &match self.find(job, contender) {
                    Some(Measured { times, .. }) => format!(
                        "| {job} | {contender} | {:.2} | {:.2} | {:.2} | {} |\n",
                        times.p50_us,
                        times.p99_us,
                        times.p9999_us,
                        self.ratio(job, contender, super::OURS)
                            .filter(|_| *contender != "empty")
                            .map_or_else(String::new, |ratio| format!("{ratio:.2}"))
                    ),
                    None => {
                        let reason = self.reason(job, contender);
                        format!("| {job} | {contender} | left out: {reason} | | | |\n")
                    }
                };
            }
        }
        text
    }

    /// How many times as long as ours a rival takes for the main jobs (p50); `None` if one of them was
    /// not measured.
    pub(crate) fn against(&self, rival: &str, ours: &str) -> Option<String> {
        let ratios = HEADLINES.map(|job| {
            let ratio = self.ratio(job, rival, ours)?;
            Some(format!("{job} {ratio:.1}x"))
        });
        let ratios: Option<Vec<String>> = ratios.into_iter().collect();
        Some(format!("against ONNX Runtime: {}", ratios?.join(", ")))
    }

    fn find(&self, job: Job, contender: &str) -> Option<&Measured> {
        let mut measured = self.measured.iter();
        measured.find(|measured| measured.job == job && measured.contender == contender)
    }

    fn ratio(&self, job: Job, contender: &str, ours: &str) -> Option<f64> {
        let theirs = self.find(job, contender)?.times.p50_us;
        Some(theirs / self.find(job, ours)?.times.p50_us)
    }

    fn reason(&self, job: Job, contender: &str) -> &str {
        let mut missing = self.missing.iter();
        let found = missing.find(|missing| missing.job == job && missing.contender == contender);
        found.map_or("not measured", |missing| &missing.reason)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::driver::times::Percentiles;

    fn table() -> Table {
        let measured = Job::ALL.into_iter().zip(1_u8..).flat_map(|(job, number)| {
            let of = |contender, factor: f64| Measured {
                contender,
                job,
                times: Percentiles {
                    p50_us: factor * f64::from(number),
                    p99_us: 100.0,
                    p9999_us: 1_000.5,
                },
            };
            let tract = (job != Job::Plan).then(|| of("tract", 4.0));
            [of("nsrm", 2.0), of("onnxruntime", 5.0)]
                .into_iter()
                .chain(tract)
        });
        Table {
            contenders: vec!["nsrm", "onnxruntime", "tract"],
            measured: measured.collect(),
            missing: vec![Missing {
                contender: "tract",
                job: Job::Plan,
                reason: "too hard".to_owned(),
            }],
        }
    }

    #[test]
    fn the_file_has_a_line_for_each_measurement() {
        let text = table().csv();
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[0], "job,contender,p50_us,p99_us,p9999_us");
        assert_eq!(lines[1], "plan,nsrm,2.000,100.000,1000.500");
        assert_eq!(lines.len(), 1 + 3 * Job::ALL.len() - 1);
    }

    #[test]
    fn the_table_says_what_is_left_out_and_why() {
        let text = table().markdown();
        assert!(text.contains("| plan | onnxruntime | 5.00 | 100.00 | 1000.50 | 2.50 |\n"));
        assert!(text.contains("| plan | tract | left out: too hard | | | |\n"));
        assert!(text.contains("| encoder | tract | 8.00 | 100.00 | 1000.50 | 2.00 |\n"));
    }

    #[test]
    fn a_ratio_above_one_means_that_ours_is_faster() {
        let line = table().against("onnxruntime", "nsrm").unwrap();
        assert_eq!(
            line,
            "against ONNX Runtime: plan 2.5x, encoder 2.5x, splitter 2.5x, crops 2.5x"
        );
        assert_eq!(table().against("tract", "nsrm"), None);
    }
}
