//! Parameters that a controller keeps, with their range and the value they begin with.
//!
//! What uses one of them reads it elsewhere; those here change nothing.

/// Name, least and largest value, first value, and whether it is a whole number.
pub(super) const KEPT: [(&str, f64, f64, f64, bool); 24] = [
    ("fenable", 0.0, 1.0, 0.0, true),
    ("sinit", 0.0, 100.0, 0.0, false),
    ("ctrlmode", 0.0, 3.0, 0.0, true),
    ("monsrc", 0.0, 7.0, 0.0, true),
    ("kp", 0.0, 10000.0, 0.0, false),
    ("ki", 0.0, 10000.0, 20.0, false),
    ("kd", 0.0, 10000.0, 0.0, false),
    ("tf", 0.0, 10000.0, 0.0, false),
    ("setlpon", 0.0, 1.0, 0.0, true),
    ("setlpf", 1.0, 10000.0, 10000.0, false),
    ("notchon", 0.0, 1.0, 0.0, true),
    ("notchf", 1.0, 10000.0, 10000.0, true),
    ("notchb", 1.0, 10000.0, 10000.0, true),
    ("poslpon", 0.0, 1.0, 0.0, true),
    ("poslpf", 1.0, 10000.0, 10000.0, false),
    ("trgfkt", 0.0, 5.0, 0.0, true),
    ("trgedg", 0.0, 3.0, 0.0, true),
    ("trgsrc", 0.0, 1.0, 0.0, true),
    ("trgss", -1e6, 1e6, 0.0, false),
    ("trgse", -1e6, 1e6, 0.0, false),
    ("trgsi", 0.001, 1e6, 1.0, false),
    ("trglen", 0.0, 255.0, 0.0, true),
    ("spisrc", 0.0, 9.0, 0.0, true),
    ("spitrg", 0.0, 1.0, 0.0, true),
];

/// The feed-forward gains, each its own parameter, of position, velocity and acceleration.
pub(super) const GAINS: [&str; 3] = ["pcf position", "pcf velocity", "pcf acceleration"];

/// What `s` answers.
pub(super) const COMMANDS: &str = "s,set,meas,imeas,ctrlmode,temp,stat,posmin,posmax,avmin,avmax,unitcl,unitol,modsrc,\
    monsrc,desc,acserno,acmeasure,cl,sr,kp,ki,kd,tf,pcf,setlpon,setlpf,notchon,notchf,notchb,poslpon,poslpf,fenable,\
    sinit,grun,gsarb,gearb,gcarb,goarb,giarb,gtarb,gbarb,gparb,gsave,gload,recsrc,recast,recstr,reclen,recrun,recidx,\
    recout,recoutf,trgfkt,trgedg,trgsrc,trgss,trgse,trgsi,trglen,spisrc,spitrg";
