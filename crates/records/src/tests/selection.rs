//! What the user says of columns, and what a table makes of it.

use crate::formats::{ColumnSelection, Table};
use crate::record::{Record, Units};

const TEXT: &[u8] = b"t_s,u_V,y_um,r_um\n0,0,0,1\n0.5,1,20,2\n1,2,30,3\n1.5,3,50,4\n";

fn table(text: &[u8]) -> Table {
    Table::parse(text).unwrap()
}

fn every_option(mark: &str, number: f64) -> ColumnSelection {
    let text = || Some(mark.to_string());
    ColumnSelection {
        ts: Some(number),
        fs: Some(number),
        time_unit: text(),
        time_col: text(),
        input_col: text(),
        output_col: text(),
        input_unit: text(),
        output_unit: text(),
        input_scale: text(),
        output_scale: text(),
        from: Some(number),
        to: Some(number),
    }
}

#[test]
fn options_that_are_missing_are_those_of_the_profile() {
    let (flags, profile) = (every_option("flag", 1.0), every_option("profile", 2.0));
    assert_eq!(flags.clone().or(profile.clone()), flags);
    assert_eq!(ColumnSelection::default().or(profile.clone()), profile);
    let rate = ColumnSelection { fs: Some(5.0), ..ColumnSelection::default() };
    let period = ColumnSelection { ts: Some(2.0), ..ColumnSelection::default() };
    assert_eq!(rate.clone().or(period.clone()), rate);
    assert_eq!(period.clone().or(rate), period);
}

#[test]
fn a_profile_is_read_as_it_was_written() {
    let profile = ColumnSelection { fs: None, input_scale: Some("20".into()), ..every_option("1", 0.25) };
    assert_eq!(ColumnSelection::from_toml(&profile.to_toml()).unwrap(), profile);
    let message = ColumnSelection::from_toml("ts = 1.0\n\nfrom = = 2\n").unwrap_err().to_string();
    assert!(message.starts_with("line 3: not TOML: "), "{message}");
    assert!(ColumnSelection::from_toml("colour = 1").is_err());
}

#[test]
fn a_period_and_a_rate_say_the_same_and_only_one_is_given() {
    let period = |ts, fs| ColumnSelection { ts, fs, ..ColumnSelection::default() }.period();
    assert_eq!(period(None, Some(4.0)), Ok(Some(0.25)));
    assert_eq!(period(Some(4.0), None), Ok(Some(4.0)));
    assert_eq!(period(None, None), Ok(None));
    assert!(period(Some(1.0), Some(1.0)).unwrap_err().to_string().contains("give either ts or fs"));
    assert!(period(Some(0.0), None).is_err() && period(None, Some(-1.0)).is_err());
}

#[test]
fn a_reference_is_found_before_an_output() {
    let (any, named) = (ColumnSelection::default(), |name: &str| ColumnSelection {
        output_col: Some(name.into()),
        ..ColumnSelection::default()
    });
    let both = table(TEXT);
    assert_eq!(both.reference(&any).unwrap().samples, [1.0, 2.0, 3.0, 4.0]);
    assert_eq!(both.reference(&named("y_um")).unwrap().samples, [0.0, 20.0, 30.0, 50.0]);
    let alone = table(b"t_s,y_um\n0,7\n0.5,8\n");
    assert_eq!(alone.reference(&any).unwrap().samples, [7.0, 8.0]);
    let requested = table(b"t_s,Target position [um],Sensor [um]\n0,7,1\n0.5,8,2\n");
    assert_eq!(requested.reference(&any).unwrap().samples, [7.0, 8.0]);
    assert_eq!(both.input(&any).unwrap().samples_in("mV", "the input"), Ok(vec![0.0, 1e3, 2e3, 3e3]));
    let message = both.input(&any).unwrap().samples_in("um", "the input").unwrap_err().to_string();
    assert!(message.contains("the input") && message.contains('V') && message.contains("um"), "{message}");
}

#[test]
fn rows_are_timed_by_a_column_an_option_or_the_format() {
    let any = ColumnSelection::default();
    assert!(table(TEXT).is_timed(&any));
    let untimed = table(b"u_V,y_um\n0,7\n1,8\n");
    assert!(!untimed.is_timed(&any));
    assert!(untimed.is_timed(&ColumnSelection { fs: Some(10.0), ..ColumnSelection::default() }));
    let stated = b"# REM E-709\n# SEPARATOR = 32\n# DIM = 2\n# SAMPLE_TIME = 0.0005\n# NDATA = 2\n# NAME0 = u_V\n\
                   # NAME1 = y_um\n# END_HEADER\n0 0 \n1 20 \n";
    assert!(Table::read("array.gcs", stated).unwrap().is_timed(&any));
}

#[test]
fn whole_numbers_are_points_in_time_since_1970_in_milliseconds_or_by_their_name() {
    let times = |name: &str, first: u64| {
        let rows: Vec<String> = (0..4).map(|k| format!("{},{k},{}\n", first + 5 * k, 20 * k)).collect();
        table(format!("{name},u_V,y_um\n{}", rows.concat()).as_bytes()).record(&ColumnSelection::default())
    };
    assert_eq!(times("stamped", 1_700_000_000_000).unwrap().ts(), 5e-3);
    assert_eq!(times("timestamp", 1_700_000_000).unwrap().ts(), 5.0);
    // Perhaps a counter.
    assert!(times("stamped", 1_700_000_000).is_err());
}

#[test]
fn factors_scale_samples_and_replace_units() {
    let units = Units { u: "mV".into(), y: "V".into() };
    let record = Record::new(1.0, vec![1.0, -2.0], vec![0.2, 0.4]).unwrap().with_units(units);
    let scaled = record.scaled(" 20 ", "5um/V").unwrap();
    assert_eq!((scaled.u(), scaled.y(), scaled.ts()), (&[20.0, -40.0][..], &[1.0, 2.0][..], 1.0));
    assert_eq!((&*scaled.units().u, &*scaled.units().y), ("mV", "um"));
    assert_eq!(scaled.history(), ["input scaled by 20", "output scaled by 5um/V"]);
    // The factor is for volts, the column in millivolts.
    assert_eq!(record.scaled("1000V/V", "").unwrap().u(), [1.0, -2.0]);
    assert_eq!(record.scaled("", " ").unwrap(), record);
    let message = record.scaled("", "5um/A").unwrap_err().to_string();
    assert!(message.contains("5um/A") && message.contains("the column is in V"), "{message}");
    for refused in ["0", "x", "inf", "um"] {
        assert!(record.scaled(refused, "").is_err(), "{refused}");
    }
}

#[test]
fn uneven_times_are_interpolated_only_on_request() {
    let uneven = table(b"t_s,u_V,y_um\n0,0,0\n1.2,12,24\n2.0,20,40\n3.2,32,64\n4,40,80\n");
    assert!(uneven.record(&ColumnSelection::default()).is_err());
    let record = uneven.resampled(&ColumnSelection::default(), Some(1.0)).unwrap();
    assert_eq!((record.ts(), record.len()), (1.0, 5));
    record.u().iter().zip(0..).for_each(|(u, k)| assert!((u - 10.0 * f64::from(k)).abs() < 1e-12));
    record.y().iter().zip(0..).for_each(|(y, k)| assert!((y - 20.0 * f64::from(k)).abs() < 1e-12));
    assert!(record.history()[0].starts_with("uneven times (steps of 0.8 s to 1.2 s"), "{:?}", record.history());
    let cut = ColumnSelection { from: Some(1.0), ..ColumnSelection::default() };
    let record = uneven.resampled(&cut, Some(1.0)).unwrap();
    assert!((record.u()[0] - 12.0).abs() < 1e-12 && (record.u()[2] - 32.0).abs() < 1e-12, "{:?}", record.u());
    let back = table(b"t_s,u_V,y_um\n0,0,0\n2,1,2\n1,2,4\n");
    assert!(back.resampled(&ColumnSelection::default(), Some(1.0)).is_err());
}
