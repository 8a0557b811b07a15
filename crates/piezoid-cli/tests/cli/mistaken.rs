//! Records with a channel, a unit or a rate that is not what it is called: the likely cause and the remedy are named.

use crate::bench::Bench;

/// A bench whose `rising.csv` is written again as `wrong.csv`, with other values in its rows.
fn bench(change: impl Fn([f64; 3]) -> [f64; 3]) -> Bench {
    let bench = Bench::stocked();
    bench.run("excite rising-sine --amplitude 28V --frequency 5Hz --ts 0.5ms --duration 2s -o drive.csv").ok();
    bench.run("simulate drive.csv --plant pl140 -o rising.csv").ok();
    let text = bench.text("rising.csv");
    let row = |line: &str| {
        let cells: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
        let [t, u, y] = change([cells[0], cells[1], cells[2]]);
        format!("{t},{u},{y}\n")
    };
    bench.write("wrong.csv", "t_s,u_V,y_um\n".to_string() + &text.lines().skip(1).map(row).collect::<String>());
    bench
}

const IDENTIFY: &str = "identify sine20.csv wrong.csv --operator PI -o m.json";
const VALIDATE: &str = "validate wrong.csv --model model.json";

#[test]
fn swapped_columns_are_named() {
    let bench = bench(|[t, u, y]| [t, y, u]);
    let says = ["input and output seem to be swapped", "exchange them"];
    bench.refused("identify wrong.csv --operator PI -o m.json").says(&says);
    bench.run(VALIDATE).ok().says(&says);
}

#[test]
fn millimetres_called_micrometres_are_named() {
    let bench = bench(|[t, u, y]| [t, u, 1e-3 * y]);
    let says = ["its values seem to be in mm, not in um: correct the unit in its header, or state it"];
    bench.run(IDENTIFY).ok().says(&says);
    bench.run(VALIDATE).ok().says(&says).says(&["e-4 times that of the model"]);
}

#[test]
fn values_a_thousand_times_too_large_are_named() {
    let of_output = bench(|[t, u, y]| [t, u, 1e3 * y]);
    let says = ["its values seem to be in nm, not in um", "more than any piezo actuator moves"];
    of_output.run(IDENTIFY).ok().says(&says);
    of_output.run(VALIDATE).ok().says(&says);
    let of_input = bench(|[t, u, y]| [t, 1e3 * u, y]);
    of_input.run(VALIDATE).ok().says(&["at 933.3 times the range, its values seem to be in mV, not in V"]);
}

#[test]
fn a_rate_stated_as_a_period_is_named() {
    let bench = bench(|row| row);
    let text = bench.text("wrong.csv");
    let without_time = |line: &str| line.split_once(',').unwrap().1.to_string() + "\n";
    bench.write("bare.csv", text.lines().map(without_time).collect::<String>());
    let says = ["if 2000 is the sampling rate in Hz, state it as such"];
    for file in ["bare.csv", "wrong.csv"] {
        bench.run(&format!("identify {file} --ts 2000 --operator PI -o m.json")).ok().says(&says);
        bench.refused(&format!("validate {file} --ts 2000 --model model.json")).says(&says);
    }
    bench.run("validate bare.csv --fs 2000 --model model.json").ok();
}

#[test]
fn volts_in_thousandths_are_converted() {
    let bench = Bench::stocked();
    let flags = "--ts 1ms --duration 0.5s -o";
    bench.run(&format!("excite sine --amplitude 500 --frequency 5Hz --unit mV {flags} mv.csv")).ok();
    bench.run(&format!("excite sine --amplitude 0.5V --frequency 5Hz {flags} v.csv")).ok();
    for file in ["mv", "v"] {
        bench.run(&format!("simulate {file}.csv --plant pl140 -o {file}_y.csv")).ok();
    }
    let last =
        |file: &str| bench.text(file).lines().last().unwrap().rsplit(',').next().unwrap().parse::<f64>().unwrap();
    let [mv, v] = [last("mv_y.csv"), last("v_y.csv")];
    assert!((mv - v).abs() < 1e-9 && v != 0.0, "{mv} {v}");
}

#[test]
fn a_negative_value_may_carry_its_unit() {
    let bench = Bench::stocked();
    bench.run("prepare sine20.csv --delay -0.35ms -o late.csv").ok().says(&["shifted later by 0.00035 s"]);
    bench.run("plan --range -30V 30V --bandwidth 80 --driver pl140 -o drives --json plan.json").ok();
    assert!(bench.text("plan.json").contains("\"file\": \"rise3_u.csv\""));
}

#[test]
fn a_reference_in_another_unit_is_named() {
    let bench = Bench::stocked();
    for (unit, amplitude) in [("mm", "400"), ("um", "400000")] {
        let path = format!("excite sine --frequency 5 --amplitude {amplitude} --unit {unit} --ts 5e-4 --duration 1");
        bench.run(&format!("{path} -o r.csv")).ok();
        bench
            .refused("compensate r.csv --model model.json -o u.csv")
            .says(&["it runs from -4e5 to 4e5 um, but within", "times the stroke: check the unit of the reference"]);
    }
}
