use super::*;
use crate::simulated::CYCLE;
use crate::{ConnectOptions, Drive, Function, InstrumentOptions, Model, Protocol};
use piezoid::System;
use piezoid::plant::{Plant, Preset};
use piezoid::progress::Stage;
use std::cell::Cell;
use std::collections::BTreeMap;
use std::ops::ControlFlow;

/// Files in memory.
#[derive(Default)]
struct Memory {
    files: BTreeMap<String, File>,
    /// The number of files from which on no more are kept.
    most: Option<usize>,
    is_refused: bool,
    /// What it was to agree to.
    agreed: Vec<String>,
}

impl Journal for Memory {
    fn agree(&mut self, agenda: &Agenda) -> Result<(), Error> {
        self.agreed.push(agenda.text());
        let Agenda { plan, resumed, seconds, .. } = agenda;
        let missing = || plan.drives.iter().filter(|drive| resumed.iter().all(|name| name != drive.name));
        let records: f64 = missing().map(|drive| plan.duration(drive)).sum();
        let waits = 2.0 * (missing().count() + 2) as f64;
        assert!(*seconds > records + waits, "{seconds} s, {resumed:?} measured earlier");
        if self.is_refused { Err(Error::Content("not agreed".into())) } else { Ok(()) }
    }

    fn earlier(&self, name: &str) -> Option<File> {
        self.files.get(name).cloned()
    }

    fn keep(&mut self, files: Vec<File>) -> Result<(), Error> {
        if self.most.is_some_and(|most| self.files.len() >= most) {
            return Err(Error::Content("the folder is full".into()));
        }
        self.files.extend(files.into_iter().map(|file| (file.name.clone(), file)));
        Ok(())
    }
}

/// A campaign on a plant, and how many voltages it was given.
fn campaign(
    plant: &str,
    range: (f64, f64),
    operator: &str,
    memory: &mut Memory,
    progress: &mut Progress,
) -> (Result<Campaign, Error>, Vec<String>, usize) {
    let (played, mut notes) = (Cell::new(0), Vec::new());
    let plant = Plant::new(&Preset::find(plant).unwrap().spec(), 1e-3).unwrap();
    let mut x = plant.initial();
    let call = |u: &[f64]| {
        played.set(played.get() + u.len());
        Ok(plant.resume(&mut x, u))
    };
    let options =
        CampaignOptions { bandwidth: 20.0, wait: 2.0, operator: operator.into(), ..CampaignOptions::default() };
    let mut function = Function::new(range, 1e-3, Box::new(call), progress).unwrap();
    let found = options.on(&mut function, None, memory, &mut notes, &mut Stage::ignore);
    drop(function);
    (found, notes, played.get())
}

/// Of a bender about 0 V and of a stack about the middle of its range, whose states differ from that of a first rise.
#[test]
fn a_compensated_path_is_twenty_times_better_than_a_straight_line() {
    for (plant, range) in [("pl140", (-30.0, 30.0)), ("p885", (0.0, 100.0))] {
        let mut memory = Memory::default();
        let found = campaign(plant, range, "preisach", &mut memory, &mut Stage::ignore).0.unwrap();
        let paths = (found.straight.text(), found.compensated.text());
        assert!(found.better() > 20.0, "{plant}: {paths:?}");
        let of_model = found.validated.total().rmse;
        assert!(found.compensated.metrics.rmse < 1.5 * of_model, "{plant}: {paths:?}, model {of_model}");
        assert_eq!((found.unfinished.clone(), found.left.voltage), (None, Some(0.0)));
        for name in ["small_u.csv", "path.csv", "model.json", "compensated.csv", "campaign.json"] {
            assert!(memory.files.contains_key(name), "{name}");
        }
        let page = memory.files["campaign.html"].text().unwrap().to_string();
        assert!(page.contains("smaller rms error than with a straight line") && page == found.page().html());
        assert_eq!(found.to_json()["better"], found.better());
    }
}

#[test]
fn what_was_measured_is_not_measured_again_unless_its_drive_changed() {
    let (mut memory, range) = (Memory { most: Some(6), ..Memory::default() }, (-30.0, 30.0));
    let (error, _, all) = campaign("paper", range, "proportional", &mut memory, &mut Stage::ignore);
    let error = error.unwrap_err().to_string();
    assert_eq!(error, "the folder is full; the last voltage of the function was 0.000 V");
    memory.most = None;
    memory.files.get_mut("rise1_u.csv").unwrap().bytes.push(b'\n');
    let (found, _, again) = campaign("paper", range, "proportional", &mut memory, &mut Stage::ignore);
    let found = found.unwrap();
    assert_eq!(found.resumed, ["small", "rise2"]);
    let [first, second] = &memory.agreed[..] else { panic!("{:?}", memory.agreed) };
    assert!(
        first.starts_with("a function: axis 1 is to move between -28.5 and 28.5 V, for ")
            && first.ends_with(" s or more.")
    );
    assert!(second.ends_with("Measured earlier, and not again: small, rise2."), "{second}");
    assert!(again > all, "{again} {all}");
}

#[test]
fn nothing_moves_before_it_is_agreed_or_after_it_is_cancelled() {
    let mut memory = Memory { is_refused: true, ..Memory::default() };
    let (error, _, played) = campaign("paper", (-30.0, 30.0), "proportional", &mut memory, &mut Stage::ignore);
    assert_eq!((error.unwrap_err().to_string(), played), ("not agreed".into(), 0));
    let calls = Cell::new(0);
    let mut progress = |_: Stage| {
        calls.set(calls.get() + 1);
        if calls.get() > 3 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let mut memory = Memory::default();
    let (error, notes, _) = campaign("paper", (-30.0, 30.0), "proportional", &mut memory, &mut progress);
    let what = match error {
        Err(Error::Cancelled { what, .. }) => what,
        other => panic!("{other:?}"),
    };
    assert_eq!(what, "record rise1: the drive is played");
    assert_eq!(notes.last().unwrap(), "the last voltage of the function was 0.000 V");
    // One record after its demagnetisation; then the next demagnetisation.
    assert_eq!((calls.get(), memory.files.len()), (4, 2));
}

#[test]
fn a_rehearsal_needs_no_controller_and_its_records_are_no_measurement() {
    let options = |range| CampaignOptions {
        range: Some(range),
        bandwidth: 20.0,
        wait: 2.0,
        operator: "preisach".into(),
        ..CampaignOptions::default()
    };
    let plant = Preset::find("pl140").unwrap().spec().into();
    let (mut memory, mut notes) = (Memory::default(), Vec::new());
    let mut run = |options: &CampaignOptions, memory: &mut Memory| {
        options.rehearse(("pl140", &plant), None, memory, &mut notes, &mut Stage::ignore)
    };
    let found = run(&options((-30.0, 30.0)), &mut memory).unwrap();
    assert!(found.better() > 20.0, "{:?}", (found.straight.text(), found.compensated.text()));
    assert_eq!((&*found.setup.identity, found.left.voltage), ("pl140, simulated", Some(0.0)));
    let resumed = run(&options((-30.0, 30.0)), &mut memory).unwrap().resumed;
    assert_eq!(resumed, ["small", "rise1", "rise2", "rise3", "creep", "path"]);
    let message = campaign("pl140", (-30.0, 30.0), "preisach", &mut memory, &mut Stage::ignore).0.err().unwrap();
    let expected =
        "small.csv was measured by `pl140, simulated`, not by `a function`: take another folder for this campaign";
    assert_eq!(message.to_string(), expected);
    let message = run(&options((-30.0, 90.0)), &mut Memory::default()).unwrap_err().to_string();
    assert!(message.contains("outside -30 to 30 V"), "{message}");
    let connection = ConnectOptions { port: 1, ..ConnectOptions::default() };
    let instrument = InstrumentOptions { connection, ..InstrumentOptions::default() };
    let message = run(&CampaignOptions { instrument, ..options((-30.0, 30.0)) }, &mut Memory::default()).unwrap_err();
    assert_eq!(message.to_string(), "port = 1: has no effect on a simulated plant, which has no controller");
}

#[test]
fn a_function_that_returns_too_few_displacements_is_refused() {
    let mut ignore = Stage::ignore;
    let call = |u: &[f64]| Ok(u[1..].to_vec());
    let mut function = Function::new((-1.0, 1.0), 1e-3, Box::new(call), &mut ignore).unwrap();
    let drive = Drive { what: "", u: &[0.0, 0.5], ts: 1e-3, ramp: 0.0, settle: 0.0, joined: false };
    let message = function.play(&drive).unwrap_err().to_string();
    assert_eq!(message, "the function returns 1 displacements for 2 voltages: return one for each");
}

/// The displacement of a plant that is given all that a campaign played after its records, without a controller.
fn without_a_controller(found: &Campaign, plant: &str, wait: f64) -> Vec<f64> {
    let Campaign { plan, straight, compensated, .. } = found;
    let plant = Plant::new(&Preset::find(plant).unwrap().spec(), CYCLE).unwrap();
    let mut x = plant.initial();
    // Each voltage is held; a sample is read at its beginning.
    let mut play = |u: &[f64], ts: f64| -> Vec<f64> {
        let cycles = (ts / CYCLE).round() as usize;
        u.iter().map(|u| plant.resume(&mut x, &vec![*u; cycles])[0]).collect()
    };
    let PlannedDrive { u: decay, ts: rare, .. } = &plan.demagnetisation;
    let rise: Vec<f64> = (0..=1000).map(|k| plan.middle() * f64::from(k) / 1000.0).collect();
    play(&rise, 1e-3);
    play(decay, *rare);
    play(&[plan.middle()], wait);
    play(straight.record.u(), plan.ts);
    play(decay, *rare);
    play(&[plan.middle()], wait);
    play(compensated.record.u(), plan.ts)
}

/// Takes four minutes, because it waits with the clock: `cargo test -p piezoid-instruments -- --ignored --nocapture`.
#[test]
#[ignore = "takes minutes"]
fn on_every_controller_a_path_is_followed_as_without_one() {
    let one = |(model, plant, range): (Model, &str, (f64, f64))| {
        let port = crate::measuring::served(&crate::Simulation { model, plant: plant.into(), ..Default::default() });
        let protocol = if model == Model::Nv200 { Protocol::Nv200 } else { Protocol::Gcs };
        let connection = ConnectOptions { protocol, port, ..ConnectOptions::default() };
        let instrument = InstrumentOptions { connection, ..InstrumentOptions::default() };
        let options = CampaignOptions {
            instrument,
            bandwidth: 40.0,
            range: Some(range),
            operator: "preisach".into(),
            ..CampaignOptions::default()
        };
        let mut memory = Memory::default();
        let found = options.run(None, &mut memory, &mut Vec::new(), &mut Stage::ignore).unwrap();
        let Track { r, path, metrics, .. } = &found.compensated;
        let y = without_a_controller(&found, plant, options.wait);
        let error = |y: &[f64]| -> Vec<f64> { y.iter().zip(r).map(|(y, r)| y - r).collect() };
        let direct = error(&y);
        // The zero of the sensor and creep before the path are not its error.
        let rms = |error: &[f64]| {
            let mean = piezoid_numerics::series::mean(error);
            (error.iter().map(|e| (e - mean) * (e - mean)).sum::<f64>() / error.len() as f64).sqrt()
        };
        let [measured, direct] = [error(found.compensated.record.y()), direct].map(|e| rms(&e[path.clone()]));
        let (name, better, whole) = (model.title(), found.better(), metrics.rmse);
        println!(
            "{name}, {plant}: {better:.0} times better, {whole:.4} um; without its mean {measured:.4}, without a controller {direct:.4}"
        );
        assert!(better > 20.0 && measured < 1.5 * direct, "{name}");
    };
    let all = [
        (Model::E727, "pl140", (-30.0, 30.0)),
        (Model::E754, "p885", (10.0, 90.0)),
        (Model::E709, "p885", (0.0, 100.0)),
        (Model::OpenLoop, "pl140", (-30.0, 30.0)),
        (Model::Nv200, "pl140", (-30.0, 30.0)),
    ];
    std::thread::scope(|scope| all.map(|each| scope.spawn(move || one(each))).map(|thread| thread.join().unwrap()));
}
