"""Contacts by steps of one length instead of events, for models with very many of them.

moreau     a step: free motion, then the impulses that keep all gaps
struck     the contacts of a step, and what they do to velocities
ports      where contacts push: touches and bodies of crowds, and what forces there do
crowd      which bodies of a crowd are near each other, and where they would touch
angles     sine and cosine with the same bits everywhere
impulses   the impulses of all contacts at once, by projected Gauss-Seidel
refusal    what cannot be stepped, in words
"""
