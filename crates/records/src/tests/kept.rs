//! Files that are read, described and refused as before.

use super::formats::FILES;
use crate::formats::{ColumnSelection, Table};
use piezoid_testing::assert_kept;

/// Texts as instruments, scripts and people write them, whole and wrong.
const TEXTS: [&str; 26] = [
    "Zeit [ms];Spannung [V];Weg [\u{b5}m]\n0;1,5;2,25\n0,5;-1;3\n1;2;4\n",
    "t_s,u_V,y_um\n0,0,0\n0.0005,1,20\n0.0015,2,40\n0.0020,3,60\n",
    "t_s,u_V,y_um\n0,0,0\n0.001,1,20\n0.001,2,40\n",
    "t_s,u_V,y_um\n0,0,0\n0.001,1,\n0.002,2,40\n0.003,nan,60\n0.004,4,80\n0.005,5,90\n",
    "u_V,y_um\n0,0\n1,20\n",
    "Time,Drive,Sensor 1,Sensor 2\n0,0,0,1\n0.1,1,20,3\n0.2,0,10,2\n",
    "time (s)\tvoltage (V)\tposition (nm)\tcurrent (mA)\n0\t0\t0\t5\n1\t1\t20\t6\n2\t0\t3\t7\n",
    "# fs = 2000 Hz\n# u in V\nu_V y_um\n0 1\n2 3\n4 5\n",
    "Sampling rate: 1000 Hz\nchannel,1,2\nname,Input,Output\nunit,V,um\n0,1\n2,3\n4,5\n",
    "0 1 2\n0.5 3 4\n1 5 6\n",
    "t_s,u_V,y_um\n0,0,0\n0.001,1,20\nt_s,u_V,y_um\n0,2,40\n0.001,3,60\n",
    "t_s,u_V,u_V,y_um\n0,0,0,1\n0.1,1,2,3\n0.2,1,2,3\n",
    "t_s,u_V,y_um,y_nm\n0,0,0,1\n0.1,1,2,3\n0.2,1,2,3\n",
    "t_us,u_mV,y_mm\n0,1500,0.02\n500,1000,0.03\n1000,500,0.04\n",
    "date,time,U [V],x [um]\n2024-03-05,14:07:09.0,1,2\n2024-03-05,14:07:09.5,3,4\n2024-03-05,14:07:10.0,5,6\n",
    "2024-03-05T14:07:09.000;1;2\n2024-03-05T14:07:09.001;3;4\n2024-03-05T14:07:09.002;5;6\n",
    "t_s,u_V,y_um\n0,1e400,0\n0.1,1,2\n0.2,3,4\n",
    "t_s,u_V,y_um\n0,0x1F,0\n0.1,1,2\n0.2,3,4\n",
    "t_s,u_V,y_um\r\n0,\"1\",\"2\"\r\n0.1,\"3\",\"4\"\r\n",
    "t_s|u_V|y_um\n0|1.000.000,5|2\n1|2.000,5|3\n",
    "sample,Command (V),Reading (um),Setpoint (um)\n0,0,0,1\n1,1,20,21\n2,2,30,31\n",
    "Ch1 - Voltage (V),Ch2 - Displacement (um)\n0,1\n2,3\n",
    "t_s,u_V,y_um\n",
    "nothing here\n",
    "t_h,u_kV,y_urad\n0,0.1,5\n1,0.2,6\n2,0.3,7\n",
    "t_s,u_V,y_um,u_V_read\n0,0,1,0.1\n0.5,1,2,0.9\n1,2,3,2.1\n",
];

#[test]
fn files_are_understood_and_refused_as_they_were() {
    let any = ColumnSelection::default();
    let selections = [
        any.clone(),
        ColumnSelection { fs: Some(1000.0), ..any.clone() },
        ColumnSelection { from: Some(0.0011), to: Some(0.5), ..any.clone() },
        ColumnSelection {
            input_col: Some("2".into()),
            output_col: Some("3".into()),
            time_unit: Some("ms".into()),
            ..any.clone()
        },
        ColumnSelection {
            input_scale: Some("20".into()),
            output_scale: Some("5um/V".into()),
            output_unit: Some("V".into()),
            ..any
        },
    ];
    let files = FILES.iter().map(|(_, name, bytes, _)| (*name, *bytes));
    let mut lines = Vec::new();
    for (name, bytes) in files.chain(TEXTS.iter().map(|text| ("text.csv", text.as_bytes()))) {
        let table = match Table::read(name, bytes) {
            Ok(table) => table,
            Err(error) => {
                lines.push(format!("{name} {error}"));
                continue;
            }
        };
        lines.push(format!("{name} {}", table.layout("csv")));
        for (k, selection) in selections.iter().enumerate() {
            lines.push(format!("{k} {:?}", table.resampled(selection, (k == 1).then_some(5e-4))));
            lines.push(format!("{} {}", table.profile(selection).to_toml(), table.is_timed(selection)));
        }
        let [input, reference] = [table.input(&selections[0]), table.reference(&selections[0])];
        lines.push(format!("{input:?} {reference:?}"));
        lines.extend(table.described(&selections[0]).iter().map(ToString::to_string));
    }
    assert_kept("files", &lines.join("\n"));
}
