//! usage: trial OPERATORS FOLDER...
use piezoid::formats::ColumnSelection;
use piezoid::validation::{Offset, ValidateOptions};
use piezoid::{IdentifyOptions, Records};
use piezoid::{Model, Record};
use std::time::Instant;

fn main() {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let operators = &args[0];
    let mut medians = Vec::new();
    for folder in &args[1..] {
        let text = std::fs::read_to_string(format!("{folder}/truth.json")).unwrap_or("{\"records\":{}}".into());
        let truth: serde_json::Value = serde_json::from_str(&text).unwrap();
        let mut names: Vec<String> =
            std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.retain(|n| n.ends_with(".csv"));
        names.sort();
        let read = |name: &String| {
            Record::from_csv(&std::fs::read(format!("{folder}/{name}")).unwrap(), &ColumnSelection::default()).unwrap()
        };
        let of = |kind: &str| names.iter().filter(|n| n.starts_with(kind)).map(read).collect::<Vec<_>>();
        let (small, train) = (of("small"), of("train"));
        let start = Instant::now();
        let log = std::cell::RefCell::new((String::new(), Instant::now(), 0usize, 0usize));
        let options = IdentifyOptions { operator: operators.clone(), ..IdentifyOptions::default() };
        let found = match (Records { small_signal: &small, large_signal: &train }).identify(&options, &mut |stage| {
            let mut l = log.borrow_mut();
            if l.0 != stage.what || stage.done != l.3 {
                if std::env::var_os("PZ_TIME").is_some() && !l.0.is_empty() {
                    eprintln!("   {} {:.1} s, {} steps", l.0, l.1.elapsed().as_secs_f64(), l.2);
                }
                *l = (stage.what.to_string(), Instant::now(), 0, stage.done);
            }
            l.2 += 1;
            std::ops::ControlFlow::Continue(())
        }) {
            Ok(found) => found,
            Err(e) => {
                println!("{folder}: {e}");
                continue;
            }
        };
        let seconds = start.elapsed().as_secs_f64();
        if std::env::var_os("PZ_TIME").is_some() {
            let l = log.borrow();
            eprintln!("   {} {:.1} s, {} steps", l.0, l.1.elapsed().as_secs_f64(), l.2);
        }
        let model: Model = found.model;
        let mut ratios = Vec::new();
        let mut line = String::new();
        for name in names.iter().filter(|n| n.starts_with("test") || n.starts_with("later")) {
            let record = read(name);
            let of = &truth["records"][name];
            let floor = of["day_nrmse_percent"].as_f64().or(of["floor_nrmse_percent"].as_f64());
            let skip = if floor.is_some() {
                0.1 * of["seconds"].as_f64().unwrap()
            } else if name == "test_random.csv" {
                0.0
            } else {
                1.2
            };
            let v = model.validate_with(&record, &ValidateOptions { skip, offset: Offset::Free }).unwrap();
            let e = v.metrics.nrmse_percent;
            if let Some(dir) = std::env::var_os("PZ_DUMP") {
                let rows: String = record
                    .u()
                    .iter()
                    .zip(record.y())
                    .zip(&v.simulated)
                    .map(|((u, y), s)| format!("{u} {y} {s}\n"))
                    .collect();
                std::fs::write(
                    format!("{}/{}_{}.txt", dir.to_str().unwrap(), folder.rsplit('/').next().unwrap(), name),
                    rows,
                )
                .unwrap();
            }
            // Without the drift.
            let errors: Vec<f64> =
                record.y()[v.start..].iter().zip(&v.simulated[v.start..]).map(|(y, s)| y - s).collect();
            let n = errors.len() as f64;
            let (mt, me) = ((n - 1.0) / 2.0, errors.iter().sum::<f64>() / n);
            let (mut tt, mut te, mut ee) = (0.0, 0.0, 0.0);
            for (t, e) in errors.iter().enumerate() {
                let d = t as f64 - mt;
                tt += d * d;
                te += d * (e - me);
                ee += (e - me).powi(2);
            }
            let rest = e * ((ee - te * te / tt) / ee).sqrt();
            line += &format!(
                " {} {e:.2} ({rest:.2}) /{:.2} {:?};",
                name.trim_end_matches(".csv").trim_start_matches("test_"),
                floor.unwrap_or(0.1),
                v.initial_condition
            );
            ratios.push(e / floor.unwrap_or(0.1));
        }
        ratios.sort_by(f64::total_cmp);
        let ratio = (ratios[(ratios.len() - 1) / 2] + ratios[ratios.len() / 2]) / 2.0;
        medians.push(ratio);
        println!(
            "{} {} {:.1} [{seconds:.0} s]{line}",
            folder.rsplit('/').next().unwrap(),
            model.hysteresis().operator().name,
            ratio
        );
        println!("     {}", found.linear.reason);
        println!(
            "     creep {:?} poles {:?} delay {}",
            model.creep().lags().iter().map(|l| (l.tau_s, (l.gain * 1e4).round() / 1e2)).collect::<Vec<_>>(),
            model
                .linear()
                .poles()
                .iter()
                .map(|p| ((p.hz * 10.0).round() / 10.0, (p.damping * 1e4).round() / 1e4))
                .collect::<Vec<_>>(),
            model.linear().delay()
        );
        if std::env::var_os("PZ_NOTES").is_some() {
            for note in found.notes {
                println!("     - {note}");
            }
        }
    }
    medians.sort_by(f64::total_cmp);
    println!("median {:.2}", (medians[(medians.len() - 1) / 2] + medians[medians.len() / 2]) / 2.0);
}
