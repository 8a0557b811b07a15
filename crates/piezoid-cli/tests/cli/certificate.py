"""A certificate in other programs: `certificate.py budget FILE.json` computes its budgets with GTC; `certificate.py dcc
FILE.xml` tries the Schematron of dcclib, and the schema of the PTB: the dcc.xsd that PIEZOID_DCC_SCHEMA names, or that of
the PTB if it can be fetched (it prints whether)."""

import json
import math
import os
import sys


def budget(path: str) -> None:
    from GTC import reporting, ureal

    document = json.load(open(path, encoding="utf-8"))
    budgets = [document["budget"], *document["records"], *(band["budget"] for band in document["bands"])]
    for found in budgets:
        terms = []
        for row in found["rows"]:
            nu = math.inf if row["degrees_of_freedom"] is None else row["degrees_of_freedom"]
            assert math.isclose(row["standard"] * row["divisor"], row["value"], rel_tol=1e-12), row
            quantity = ureal(0.0, row["standard"], nu, label=row["source"])
            terms.append(row["sensitivity"] * quantity)
            component = reporting.u_component(terms[-1], quantity)
            assert math.isclose(abs(component), row["contribution"], rel_tol=1e-12, abs_tol=1e-300), row
            share = 100 * row["contribution"] ** 2 / found["standard"] ** 2
            assert math.isclose(share, row["share_percent"], rel_tol=1e-9, abs_tol=1e-12), row
        total = sum(terms)
        assert math.isclose(total.u, found["standard"], rel_tol=1e-12), (total.u, found["standard"])
        nu = math.inf if found["degrees_of_freedom"] is None else found["degrees_of_freedom"]
        # GTC calls more than 1e6 degrees of freedom infinitely many.
        assert math.isclose(total.df, nu, rel_tol=1e-9) or min(total.df, nu) > 1e6, (total.df, nu)
        whole = nu if math.isinf(nu) else max(1, math.floor(nu))
        k = reporting.k_factor(whole, p=document["coverage_percent"])
        assert math.isclose(k, found["student_k"], rel_tol=1e-6), (k, found["student_k"])
        # The errors of a record may need more.
        assert math.isclose(found["k"] * total.u, found["expanded"], rel_tol=1e-9) and found["k"] >= found["student_k"]
    largest = max(found["expanded"] for found in budgets)
    assert largest <= document["expanded"] <= 1.1 * largest, (largest, document["expanded"])
    print(f"{len(budgets)} budgets agree")


def dcc(path: str) -> None:
    from dcclib.validation.schematron import SchematronValidator
    from dcclib.validation.xsd import XsdValidator

    result = SchematronValidator.for_dcc().validate_file(path)
    reports = [*result.failed_assertions, *result.successful_reports]
    wrong = [report for report in reports if report.role != "information"]
    assert not wrong, wrong
    print("Schematron: valid")
    local = os.environ.get("PIEZOID_DCC_SCHEMA")
    try:
        validator = XsdValidator.from_file(local) if local else XsdValidator.from_version("3.3.0")
    except Exception as error:  # the schema is fetched from the PTB
        print(f"schema: not fetched ({error})")
        return
    found = validator.validate_file(path)
    assert found.is_valid, vars(found)
    print("schema: valid")


if __name__ == "__main__":
    {"budget": budget, "dcc": dcc}[sys.argv[1]](sys.argv[2])
