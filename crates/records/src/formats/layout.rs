//! What the files of one rig have in common.

use super::Table;

impl Table {
    /// The layout of the file: its format, and its channels by name and unit, in their order. Files with the same
    /// layout look alike: one [`ColumnSelection`](super::ColumnSelection) reads them. How many samples they have, at
    /// which rate, and what the files are called makes no difference.
    ///
    /// ```
    /// use piezoid::formats::Table;
    /// let layout = |text: &str| Table::parse(text.as_bytes()).map(|table| table.layout("csv"));
    /// let scope = layout("TIME,CH1,CH2\ns,V,V\n0,1,2\n1,2,3\n")?;
    /// assert_eq!(scope, r#"["csv",["TIME","s"],["CH1","V"],["CH2","V"]]"#);
    /// assert_eq!(scope, layout("TIME,CH1,CH2\ns,V,V\n0,5,6\n0.5,6,7\n1,7,8\n")?);
    /// # Ok::<(), piezoid::Error>(())
    /// ```
    pub fn layout(&self, format: &str) -> String {
        let channels = self.columns.iter().chain(&self.others);
        let channel = |column: &super::column::Column| [column.name.as_str(), column.stated().unwrap_or("")].into();
        let parts = std::iter::once(serde_json::Value::from(format)).chain(channels.map(channel));
        serde_json::Value::from_iter(parts).to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A file of a scope whose head has these names and units, with so many rows every `ts`.
    fn scope(names: &str, units: &str, rows: u32, ts: f64) -> String {
        let zeros = ",0".repeat(names.matches(',').count() - 1);
        let row = |k: u32| format!("{},{}{zeros}\n", f64::from(k) * ts, f64::from(k % 7) / 2.0);
        let text = format!("{names}\n{units}\n{}", (0..rows).map(row).collect::<String>());
        let (table, format) = Table::read_from("scope.csv", text.as_bytes()).unwrap();
        table.layout(format.name)
    }

    #[test]
    fn files_of_a_rig_look_alike_whatever_their_lengths_and_rates() {
        let first = scope("x-axis,1,2", "second,Volt,Volt", 20, 1e-3);
        for (rows, ts) in [(21, 1e-3), (400, 1e-3), (20, 5e-6), (2, 0.5)] {
            assert_eq!(scope("x-axis,1,2", "second,Volt,Volt", rows, ts), first, "{rows} rows every {ts} s");
        }
    }

    #[test]
    fn another_channel_name_unit_order_or_format_is_another_layout() {
        let first = scope("x-axis,1,2", "second,Volt,Volt", 20, 1e-3);
        for (names, units) in [
            ("x-axis,1,2,3", "second,Volt,Volt,Volt"),
            ("x-axis,1,3", "second,Volt,Volt"),
            ("x-axis,2,1", "second,Volt,Volt"),
            ("x-axis,1,2", "second,Volt,Ampere"),
            ("x-axis,1,2", "ms,Volt,Volt"),
        ] {
            assert_ne!(scope(names, units, 20, 1e-3), first, "{names} in {units}");
        }
        let table = Table::parse(b"t_s,u_V,y_um\n0,1,2\n1,2,3\n").unwrap();
        assert_ne!(table.layout("csv"), table.layout("igor"));
        // Names that contain what stands between them.
        let [one, two] = ["a\",\"b", "a"]
            .map(|name| Table { columns: vec![super::super::column::Column::new(name.into())], ..Table::default() });
        assert_ne!(one.layout("csv"), two.layout("csv"));
    }
}
