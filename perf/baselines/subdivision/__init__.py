"""The subdivision-surface baseline: a model of tubes round the centrelines of a segmentation.

After Felkel, Wegenkittl, Buehler: Surface models of tube trees, CGI 2004, and the variant that Wu
et al. (2010) compare with: thinning, radii by the distance transform, a coarse mesh of square tubes
joined at branchings, three iterations of Loop's scheme.
"""
