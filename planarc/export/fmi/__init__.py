"""The Functional Mock-up Interface.

variables     what a host sees of a program: names, references, causality
description   modelDescription.xml
entries       how a function of the standard is written: its phases, its messages
derivatives   those that give derivatives
three, two    the functions of FMI 3.0 and of FMI 2.0

Reference: Functional Mock-up Interface Specification 3.0.2 and 2.0.4, https://fmi-standard.org
"""
