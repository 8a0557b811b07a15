//! The class, and the function that proves it.

use super::matlab::Matlab;
use super::{inputs, line, sfun};
use crate::Wanted;
use crate::c::{shortest, titled};
use crate::whole::{Entry, Whole};
use piezoid::number::round;
use piezoid::series::ends;
use piezoid::system::System;

impl Matlab<'_> {
    /// The class and its functions.
    pub(super) fn class(&self, whole: &Whole, wanted: &Wanted) -> String {
        let (name, units) = (self.name, wanted.model.units());
        let mut out = format!("classdef {name} < handle\n");
        out += &self.help(whole);
        out += "    properties (Constant)\n";
        out += &format!("        Ts = {} % sampling period [s]\n", shortest(wanted.model.ts(), false));
        out += &format!("        units = struct('u', {}, 'y', {})\n    end\n", quoted(&units.u), quoted(&units.y));
        out += "    properties (SetAccess = private)\n";
        for entry in &whole.entries {
            out += &format!("        {} % of {}\n", entry.state, line(&entry.about));
        }
        out += &format!("    end\n    methods\n        function obj = {name}()\n");
        out += "            % At rest.\n";
        for entry in &whole.entries {
            out += &format!("            obj.{}();\n", entry.reset);
        }
        out += "        end\n";
        for entry in &whole.entries {
            out += "\n";
            out += &self.methods(entry);
        }
        out += "    end\nend\n";
        out + &self.functions(whole)
    }

    /// What `help` says.
    fn help(&self, whole: &Whole) -> String {
        let (name, upper) = (self.name, self.name.to_uppercase());
        let precision = if self.single { ", in single precision" } else { "" };
        let mut about = vec![
            format!("{upper}  A piezo actuator and what drives it, as identified by piezoid."),
            format!("  model = {name}() is at rest and gives the numbers of {name}.c, bit by bit{precision}."),
            format!("  A sample is {name}.Ts seconds; model.units says what numbers are in."),
        ];
        for entry in &whole.entries {
            let (inputs, output) = (inputs(entry), &entry.output);
            about.push(String::new());
            about.push(format!("  {} = model.{}({inputs})", output.name, entry.step));
            about.push(format!("      takes one sample of {}.", entry.about));
            about.extend(entry.inputs.iter().map(|i| format!("      {} [{}]: {}", i.name, i.unit, i.about)));
            about.push(format!("      {} [{}]: {}", output.name, output.unit, output.about));
            about.push(format!("  {} = model.{}({inputs})", output.name, simulate(entry)));
            about.push("      takes a row or column from rest, wherever the model stands.".into());
            about.push(format!("  model.{}()", entry.reset));
            about.push("      begins anew: all that went before is forgotten.".into());
        }
        about.extend(whole.notes.iter().map(|note| format!("  Note: {note}")));
        let (low, high) = ends(whole.entries[0].vectors.inputs.iter().map(|row| row[0]));
        let (middle, half) = (round(0.5 * (low + high)), round(0.5 * (high - low)));
        about.extend([
            String::new(),
            "  Example:".into(),
            format!("      model = {name}();"),
            "      k = (0:399)';".into(),
            format!("      y = model.simulate({middle} + {half} * sin(2 * pi * k / 100));"),
            format!("      plot(k * {name}.Ts, y)"),
        ]);
        about.iter().map(|text| format!("{}\n", format!("    %{}", line(text)).trim_end())).collect()
    }

    /// The methods of an entry.
    fn methods(&self, entry: &Entry) -> String {
        let (inputs, simulate, number) = (inputs(entry), simulate(entry), self.number());
        let (state, output, first) = (entry.state, entry.output.name, entry.inputs[0].name);
        let (reset, step) = (self.own(entry.reset), self.own(entry.step));
        let given = |at: &str| entry.inputs.iter().map(|i| format!(", {number}({}{at})", i.name)).collect::<String>();
        let (now, kth) = (given(""), given("(k)"));
        let single = if self.single { ", 'single'" } else { "" };
        format!(
            "        function {}(obj)
            % Begins anew: all that went before is forgotten.
            obj.{state} = {reset}();
        end

        function {output} = {}(obj, {inputs})
            % One sample of {}.
            if ~isscalar({first})
                error('{}:scalar', '{} takes one sample: {simulate} takes a row or column');
            end
            [obj.{state}, {output}] = {step}(obj.{state}{now});
        end

        function {output} = {simulate}(~, {inputs})
            % A row or column from rest; the state of the object stays what it is.
            {output} = zeros(size({first}){single});
            s = {reset}();
            for k = 1:numel({first})
                [s, {output}(k)] = {step}(s{kth});
            end
        end
",
            entry.reset,
            entry.step,
            line(&entry.about),
            self.name,
            entry.step,
        )
    }

    /// A function that runs the vectors and says how far off the class is, and the S-functions where Simulink has them.
    pub(super) fn test(&self, whole: &Whole) -> String {
        let (name, upper) = (self.name, self.name.to_uppercase());
        let mut out = format!(
            "function {name}_test()
    %{upper}_TEST  Runs {name} on recorded inputs and compares bit by bit with what piezoid computes.
    %   In MATLAB the S-functions too, once {name}_build has compiled them. Ends with an error where anything differs.
    model = {name}();\n"
        );
        for entry in &whole.entries {
            let vectors = &entry.vectors;
            let (simulate, inputs, output) = (simulate(entry), inputs(entry), entry.output.name);
            let values = |name: &str, values: Vec<f64>| format!("    {name} = {};\n", self.column(&values, "    "));
            out += &format!("\n    % {}.\n", line(&titled(&entry.about)));
            for (k, input) in entry.inputs.iter().enumerate() {
                out += &values(input.name, vectors.inputs.iter().map(|row| row[k]).collect());
            }
            out += &values("expected", vectors.outputs.clone());
            let each = |at: &str| entry.inputs.iter().map(|i| format!("{}{at}", i.name)).collect::<Vec<_>>().join(", ");
            let unit = quoted(&entry.output.unit);
            out += &format!(
                "    differs('{simulate}', {unit}, model.{simulate}({inputs}), expected);
    differs('{simulate} of a row', {unit}, model.{simulate}({row}).', expected(1:9));
    model.{step}({first});
    model.{reset}();
    {output} = expected(1:40);
    for k = 1:40
        {output}(k) = model.{step}({kth});
    end
    differs('{step}', {unit}, {output}, expected(1:40));
    if exist('{sfun}', 'file') == 3
        differs('{sfun}', {unit}, {}(through('{sfun}', {{{inputs}}})), expected);
    end\n",
                self.number(),
                row = each("(1:9).'"),
                first = each("(1)"),
                kth = each("(k)"),
                step = entry.step,
                reset = entry.reset,
                sfun = sfun(name, entry),
            );
        }
        let whole_numbers = if self.single { "uint32" } else { "uint64" };
        out + &format!(
            "end

function differs(what, unit, given, expected)
    wrong = sum(typecast(given, '{whole_numbers}') ~= typecast(expected, '{whole_numbers}'));
    most = max(abs(double(given) - double(expected)));
    fprintf('{name}, %s: %d of %d differ, by %g %s at most\\n', what, wrong, numel(expected), most, unit);
    if wrong > 0
        error('{name}:test', 'other numbers than those of piezoid');
    end
end

function y = through(block, inputs)
    % A model of its own: each input from a stair of samples, the output to the workspace.
    system = 'piezoid_export_test';
    load_system('simulink');
    new_system(system);
    closed = onCleanup(@() close_system(system, 0));
    set_param(system, 'SolverType', 'Fixed-step', 'Solver', 'FixedStepDiscrete', 'FixedStep', sprintf('%.17g', {name}.Ts));
    set_param(system, 'StopTime', sprintf('%.17g', (numel(inputs{{1}}) - 1) * {name}.Ts), 'ReturnWorkspaceOutputs', 'on');
    add_block('simulink/User-Defined Functions/S-Function', [system '/block'], 'FunctionName', block);
    for k = 1:numel(inputs)
        port = sprintf('u%d', k);
        samples = mat2str(double(inputs{{k}}), 17);
        add_block('simulink/Sources/Repeating Sequence Stair', [system '/' port], 'OutValues', samples);
        set_param([system '/' port], 'tsamp', sprintf('%.17g', {name}.Ts));
        add_line(system, [port '/1'], sprintf('block/%d', k));
    end
    add_block('simulink/Sinks/To Workspace', [system '/y'], 'VariableName', 'y', 'SaveFormat', 'Array');
    add_line(system, 'block/1', 'y/1');
    done = sim(system);
    y = done.get('y');
end
"
        )
    }
}

/// The method that takes whole signals through an entry.
fn simulate(entry: &Entry) -> String {
    format!("{}_simulate", entry.kind()).trim_start_matches('_').into()
}

/// `text` in quotes.
fn quoted(text: &str) -> String {
    format!("'{}'", line(text).replace('\'', "''"))
}
