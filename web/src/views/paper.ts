// The paper in our words: what each step does, and where its equations are.

export const PAPER =
  "L. Kuklisova Pavelkova, Estimation of Rate-Dependent Hammerstein Model of Piezo Bender Actuator, ICINCO 2025, identifies " +
  "the bender PL140 from simulated records. Its model has two blocks in series: hysteresis without dynamics, from the voltage u " +
  "to a hidden variable z, then a linear block from z to the displacement y.";

/** A step of the paper. */
interface Step {
  title: string;
  /** Where it is in the paper. */
  equation?: string;
  text: string;
}

export const STEPS: Step[] = [
  {
    title: "The small-signal record",
    text:
      "The bender is driven by a pseudo-random binary sequence of low amplitude. Such a small voltage opens hardly any loop, so that z " +
      "is taken to be u: the record shows the linear block alone.",
  },
  {
    title: "The linear block",
    equation: "equation (1)",
    text:
      "A difference equation of second order predicts y from its last two values and from u now and up to two samples ago. It has five " +
      "coefficients: a1, a2, b0, b1, b2. They are estimated once and serve all frequencies (Table 2).",
  },
  {
    title: "The particle swarm",
    equation: "equations (2) to (7)",
    text:
      "The coefficients are those with the smallest sum of absolute prediction errors. A swarm of candidates looks for them: each is " +
      "drawn towards its own best place and the best place of all. (2) and (3) move the candidates, (4) defines the best places, (5) to (7) " +
      "shift the search from wide to narrow over 500 iterations. As printed, (4) forgets the best place of all after each iteration. We " +
      "compute both readings, and the exact minimum by linear programming.",
  },
  {
    title: "The hidden variable",
    equation: "equation (8)",
    text:
      "Then sines drive the bender through its whole range, one record a frequency. Equation (1) solved for z recovers the hidden variable " +
      "from the measured y. That needs zeros inside the unit circle, and it amplifies the noise of the sensor.",
  },
  {
    title: "Two branches",
    equation: "Section 2.2",
    text:
      "A line separates the loop of u and z into two branches, and a spline goes through averages of each. While the voltage rises the model " +
      "reads one branch, otherwise the other: a held voltage counts as falling. This is the method printed-rule. The method held-direction " +
      "keeps the last direction instead.",
  },
  {
    title: "The test",
    equation: "Table 1",
    text:
      "A stepped voltage tests each model, and Table 1 lists the mean squared errors at 5, 20, 40 and 80 Hz. The paper leaves the number of " +
      "steps open; the study tries many. It also adds a model without hysteresis (linear), the paper's block (table2-arx), and one model for " +
      "all frequencies (joint).",
  },
];
