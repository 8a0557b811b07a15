//! Simulink and MATLAB: the C of target `c`, a level-2 S-function around each of its entries, and a class that needs no
//! compiler.
//!
//! There is no TLC file: Simulink Coder calls the S-function. The S-functions were not run in Simulink, which is not
//! free; the tests use a stand-in for its headers. The class is run in GNU Octave.

mod extract_calls;
mod matlab;

use super::c::{C, checked};
use super::template::{context, render, template};
use super::{CODE, ExportTarget, Exported, File};
use matlab::Matlab;

pub(super) const TARGET: ExportTarget = ExportTarget {
    name: "simulink",
    summary: "S-functions in C for Simulink, and a class for MATLAB and GNU Octave, in double or single precision",
    reference: "MathWorks, Writing S-Functions: level-2 C MEX S-functions",
    make: |request| {
        let whole = checked(request)?;
        let (c, name) = (C::of(&whole, request), request.name());
        let page = Matlab::of(&whole, request)?.template_context(&whole, request);
        let text = |template| render(template, page.clone());
        let [header, source] = c.pair()?;
        let mut files = vec![
            File::new(format!("{name}.h"), header),
            File::new(format!("{name}.c"), source),
            File::new(format!("{name}.m"), text(template!("simulink/class.m.j2"))?),
            File::new(format!("{name}_test.m"), text(template!("simulink/test.m.j2"))?),
            File::new(format!("{name}_build.m"), text(template!("simulink/build.m.j2"))?),
            File::new(format!("{name}.md"), text(template!("simulink/readme.md.j2"))?),
        ];
        for (k, entry) in whole.entries.iter().enumerate() {
            let text = render(template!("simulink/sfunction.c.j2"), context! { k, ..page.clone() })?;
            files.push(File::new(format!("{}_sfun.c", entry.named(name)), text));
        }
        Ok(Exported { files, functions: whole.functions(), notes: whole.notes })
    },
    ..CODE
};
